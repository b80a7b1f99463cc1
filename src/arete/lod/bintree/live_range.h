#pragma once

#include "arete/lod/bintree/odometer.h"
#include "arete/lod/bintree/record.h"

namespace arete::lod::bintree {

/// A vertex's record and the status that holds as long as its ticks last: its *live range*
/// [BaoPajarolaShafae2004, 4.4]. Deviation: the record is kept (8 bytes), so that a range that ends
/// touches no page.
struct LiveVertex {
  Record record;
  Ticks until{};          ///< live while every clock reads less
  bool selected = false;  ///< d_tau >= 0
  bool visible = false;   ///< d_c >= 0
  bool inside = false;    ///< all of its ball is within the view volume
  bool rooted = false;    ///< its ancestors are known to be there
  bool wanted() const { return selected && visible; }
  bool active() const { return wanted() && rooted; }
};

/// Which safe distance a status keeps.
enum class SafeDistance {
  Status,  ///< what the status needs [METHODS 8.4], shared out to the clocks by their rates
  Least,   ///< min(|d_tau|, |d_c|), all of it for motion: eq. 10 as printed
};

/// Sets a vertex's status for this frame and how long it lasts.
class Evaluation {
 public:
  struct Options {
    SafeDistance safe = SafeDistance::Status;
    bool culling = true;
  };
  Evaluation(const Criterion& criterion, const Odometer& odometer, const Options& options)
      : criterion_(criterion), odometer_(odometer), options_(options) {}

  void operator()(const Ball& ball, LiveVertex& vertex) const;

 private:
  Allowance selection_allowance(const Ball& ball, double distance) const;
  Allowance culling_allowance(const Ball& ball, double margin, double distance) const;
  Allowance allowance(const Ball& ball, const LiveVertex& vertex, double margin,
                      double distance) const;
  double frames(const Allowance& allowance) const;

  const Criterion& criterion_;
  const Odometer& odometer_;
  Options options_;
};

}  // namespace arete::lod::bintree
