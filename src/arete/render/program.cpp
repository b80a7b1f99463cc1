#include "arete/render/program.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "arete/core/error.h"

namespace arete::render {
namespace {

constexpr std::string_view kPreamble =
    "#version 450 core\n#extension GL_ARB_shader_draw_parameters : require\n";

[[noreturn]] void refuse(std::string_view name, std::string log) {
  std::replace(log.begin(), log.end(), '\n', ' ');
  throw Error(ErrorCode::Unsupported,
              fmt::format("OpenGL: shader {} refused: {}: update the driver", name, log));
}

GlShader compile(std::string_view name, const ShaderStage& stage) {
  GlShader shader(glCreateShader(stage.stage));
  std::string source(kPreamble);
  for (const std::string_view part : stage.parts) source += part;
  const char* text = source.c_str();
  glShaderSource(shader.get(), 1, &text, nullptr);
  glCompileShader(shader.get());
  GLint ok = GL_FALSE;
  glGetShaderiv(shader.get(), GL_COMPILE_STATUS, &ok);
  if (ok == GL_TRUE) return shader;
  std::array<char, 2048> log{};
  glGetShaderInfoLog(shader.get(), static_cast<GLsizei>(log.size()), nullptr, log.data());
  refuse(name, log.data());
}

}  // namespace

GlProgram link_program(std::string_view name, const std::vector<ShaderStage>& stages,
                       const char* captured) {
  GlProgram program(glCreateProgram());
  for (const ShaderStage& stage : stages) {
    const GlShader shader = compile(name, stage);
    glAttachShader(program.get(), shader.get());
  }
  if (captured != nullptr) {
    glTransformFeedbackVaryings(program.get(), 1, &captured, GL_INTERLEAVED_ATTRIBS);
  }
  glLinkProgram(program.get());
  GLint ok = GL_FALSE;
  glGetProgramiv(program.get(), GL_LINK_STATUS, &ok);
  if (ok == GL_TRUE) return program;
  std::array<char, 2048> log{};
  glGetProgramInfoLog(program.get(), static_cast<GLsizei>(log.size()), nullptr, log.data());
  refuse(name, log.data());
}

}  // namespace arete::render
