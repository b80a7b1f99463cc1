#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "arete/render/gl_object.h"

namespace arete::render {

struct ShaderStage {
  GLenum stage = GL_VERTEX_SHADER;
  std::vector<std::string_view> parts;  ///< sources after the common #version line, in order
};

/// Compiles and links. `captured`: varying for transform feedback, empty = none.
/// Throws: Unsupported with the driver's first message.
GlProgram link_program(std::string_view name, const std::vector<ShaderStage>& stages,
                       const char* captured = nullptr);

}  // namespace arete::render
