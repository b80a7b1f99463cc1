#pragma once

#include <array>
#include <cstdint>

#include "arete/render/gl_object.h"
#include "arete/render/renderer.h"

namespace arete::render {

enum class Mask : std::uint8_t { Off, On };

/// Every program of the renderer.
class Programs {
 public:
  /// Throws: Unsupported when the driver refuses one.
  Programs();
  /// What draws land in this style; masked = fragments without data are discarded. Programs without
  /// a discard are kept apart because they let the depth test run first.
  const GlProgram& land(const Style& style, Mask mask) const;
  const GlProgram& sky() const { return sky_; }
  /// Captures v_captured, draws nothing.
  const GlProgram& vertex_stage() const { return vertex_stage_; }

 private:
  std::array<GlProgram, 2> filled_, wire_, key_;  // by Mask
  GlProgram sky_, vertex_stage_;
};

}  // namespace arete::render
