#include "arete/render/programs.h"

#include "arete/render/program.h"

#include "shader_sources.h"

namespace arete::render {
namespace {

using Defines = std::string_view;
constexpr std::array<Defines, 2> kFilled{"", "#define MASK\n"};  // by Mask
constexpr std::array<Defines, 2> kWire{"#define WIREFRAME\n", "#define WIREFRAME\n#define MASK\n"};

ShaderStage land_vertex() {
  return {GL_VERTEX_SHADER, {kShader_frame, kShader_land_vertex}};
}

ShaderStage land_fragment(Defines defines) {
  return {GL_FRAGMENT_SHADER,
          {defines, kShader_frame, kShader_clipmap, kShader_atmosphere, kShader_land_fragment}};
}

GlProgram link_filled(Defines defines) {
  return link_program("land", {land_vertex(), land_fragment(defines)});
}

GlProgram link_wire(Defines defines) {
  return link_program(
      "wire", {land_vertex(), {GL_GEOMETRY_SHADER, {kShader_land_wire}}, land_fragment(defines)});
}

GlProgram link_key(Defines defines) {
  GlProgram program = link_program(
      "key",
      {land_vertex(),
       {GL_FRAGMENT_SHADER, {defines, kShader_frame, kShader_clipmap, kShader_key_fragment}}});
  const GLint at = glGetUniformLocation(program.get(), "key_colour");
  glProgramUniform3f(program.get(), at, kKeyLand[0] / 255.0F, kKeyLand[1] / 255.0F,
                     kKeyLand[2] / 255.0F);
  return program;
}

GlProgram link_sky() {
  return link_program(
      "sky", {{GL_VERTEX_SHADER, {kShader_frame, kShader_sky_vertex}},
              {GL_FRAGMENT_SHADER, {kShader_frame, kShader_atmosphere, kShader_sky_fragment}}});
}

}  // namespace

Programs::Programs()
    : filled_{link_filled(kFilled[0]), link_filled(kFilled[1])},
      wire_{link_wire(kWire[0]), link_wire(kWire[1])},
      key_{link_key(kFilled[0]), link_key(kFilled[1])},
      sky_(link_sky()),
      vertex_stage_(link_program("vertex stage", {land_vertex()}, "v_captured")) {}

const GlProgram& Programs::land(const Style& style, Mask mask) const {
  const auto i = static_cast<std::size_t>(mask);
  if (style.shading == Shading::Key) return key_[i];
  return style.wireframe ? wire_[i] : filled_[i];
}

}  // namespace arete::render
