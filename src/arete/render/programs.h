#pragma once

#include "arete/render/gl_object.h"
#include "arete/render/renderer.h"

namespace arete::render {

/// Every program of the renderer. Throws: kUnsupported when the driver refuses one.
struct Programs {
  Programs();
  const GlProgram& land(const Style& style) const;

  GlProgram filled, wire, key;
  GlProgram sky;
  GlProgram vertex_stage;  ///< captures v_captured, draws nothing
};

}  // namespace arete::render
