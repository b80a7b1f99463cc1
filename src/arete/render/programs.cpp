#include "arete/render/programs.h"

#include "arete/render/program.h"

#include "shader_sources.h"

namespace arete::render {
namespace {

constexpr std::string_view kWireframe = "#define WIREFRAME\n";

ShaderStage land_vertex() {
  return {GL_VERTEX_SHADER, {kShader_frame, kShader_land_vertex}};
}

ShaderStage land_wire() {
  return {GL_GEOMETRY_SHADER, {kShader_land_wire}};
}

ShaderStage land_fragment(std::string_view option) {
  return {GL_FRAGMENT_SHADER,
          {option, kShader_frame, kShader_clipmap, kShader_atmosphere, kShader_land_fragment}};
}

ShaderStage key_fragment() {
  return {GL_FRAGMENT_SHADER, {kShader_frame, kShader_clipmap, kShader_key_fragment}};
}

void set_key_colour(const GlProgram& program) {
  const GLint at = glGetUniformLocation(program.get(), "key_colour");
  glProgramUniform3f(program.get(), at, kKeyLand[0] / 255.0F, kKeyLand[1] / 255.0F,
                     kKeyLand[2] / 255.0F);
}

}  // namespace

Programs::Programs()
    : filled(link_program("land", {land_vertex(), land_fragment("")})),
      wire(link_program("wire", {land_vertex(), land_wire(), land_fragment(kWireframe)})),
      key(link_program("key", {land_vertex(), key_fragment()})),
      sky(link_program("sky", {{GL_VERTEX_SHADER, {kShader_frame, kShader_sky_vertex}},
                               {GL_FRAGMENT_SHADER,
                                {kShader_frame, kShader_atmosphere, kShader_sky_fragment}}})),
      vertex_stage(link_program("vertex stage", {land_vertex()}, "v_captured")) {
  set_key_colour(key);
}

const GlProgram& Programs::land(const Style& style) const {
  if (style.shading == Shading::kKey) return key;
  return style.wireframe ? wire : filled;
}

}  // namespace arete::render
