#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "arete/lod/patch_mesh.h"

namespace arete::lod {

/// The levels of all patches for one frame, and what the surface then errs by.
class PatchField {
 public:
  virtual ~PatchField() = default;

  /// In [0, w].
  virtual float level(int patch) const = 0;
  /// Where the side between patches at two levels stands: the same from both. "The finer patch
  /// allows the coarser one to dictate" [Wagner2003].
  virtual Standing side(float own, float other, int w) const { return {std::max(own, other), w}; }
  /// From the eye to the patch's box, metres.
  virtual double distance(int patch) const = 0;
  /// Bound on |surface - height| of the patch, metres, for the levels as they are.
  virtual double error(int patch) const = 0;
  /// Raises levels so that no patch is finer than `floor_level[patch]`: heights that are not there.
  virtual void raise(std::span<const float> floor_level) = 0;
  virtual std::uint64_t bytes() const = 0;
};

}  // namespace arete::lod
