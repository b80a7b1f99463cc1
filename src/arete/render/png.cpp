#include <cerrno>
#include <csetjmp>
#include <cstdio>
#include <memory>
#include <string>
#include <system_error>

#include <fmt/format.h>
#include <png.h>

#include "arete/core/error.h"
#include "arete/render/picture.h"

namespace arete::render {
namespace {

void ignore_warning(png_structp, png_const_charp) {}

void jump_out(png_structp png, png_const_charp) {
  png_longjmp(png, 1);
}

// Kept free of objects with destructors: libpng leaves it by longjmp.
bool write_rows(png_structp png, png_infop header, std::FILE* file, int width, int height,
                const std::uint8_t* rgb) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_init_io(png, file);
  // Level 2 with the Up filter: a seventh of level 6's time for 30 % more bytes.
  png_set_compression_level(png, 2);
  png_set_filter(png, 0, PNG_FILTER_UP);
  png_set_IHDR(png, header, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), 8,
               PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_set_sRGB(png, header, PNG_sRGB_INTENT_PERCEPTUAL);
  png_write_info(png, header);
  for (int r = 0; r < height; ++r) {
    png_write_row(png, rgb + static_cast<std::size_t>(r) * static_cast<std::size_t>(width) * 3);
  }
  png_write_end(png, header);
  return true;
}

bool encode(std::FILE* file, int width, int height, const std::uint8_t* rgb) {
  png_structp png =
      png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, jump_out, ignore_warning);
  if (png == nullptr) return false;
  png_infop header = png_create_info_struct(png);
  const bool ok = header != nullptr && write_rows(png, header, file, width, height, rgb);
  png_destroy_write_struct(&png, &header);
  return ok;
}

}  // namespace

void write_png(const std::filesystem::path& file, int width, int height,
               std::span<const std::uint8_t> rgb) {
  std::FILE* out = std::fopen(file.c_str(), "wb");
  if (out == nullptr) {
    throw Error(ErrorCode::Io, fmt::format("{}: cannot be written: {}", file.string(),
                                           std::generic_category().message(errno)));
  }
  errno = 0;
  bool ok = encode(out, width, height, rgb.data());
  ok = std::fclose(out) == 0 && ok;
  if (ok) return;
  const int why = errno != 0 ? errno : EIO;
  std::error_code ignored;
  std::filesystem::remove(file, ignored);
  throw Error(ErrorCode::Io, fmt::format("{}: writing failed: {}", file.string(),
                                         std::generic_category().message(why)));
}

}  // namespace arete::render
