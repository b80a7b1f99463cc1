#include "arete/store/raster_pyramid.h"

#include <algorithm>
#include <charconv>

#include <fmt/format.h>

#include "arete/core/error.h"

namespace arete::store {
namespace {

constexpr std::string_view kShapeWord = "\nraster ";

bool is_sane(const RasterShape& s) {
  return s.width >= 1 && s.height >= 1 && s.levels >= 1 && s.levels <= 32 && s.tile_size >= 1 &&
         s.tile_size <= 4096 && s.channels >= 1 && s.channels <= 4 && s.texels_per_post_log2 >= 0 &&
         s.texels_per_post_log2 <= 16;
}

class StoredRaster : public RasterSource {
 public:
  StoredRaster(const SegmentReader& segment, RasterShape shape, std::atomic<std::uint64_t>* damaged)
      : segment_(segment), shape_(shape), damaged_(damaged) {}

  RasterShape shape() const override { return shape_; }

  Texels read(TileId id) const override {
    Texels texels = filled_tile(shape_);
    try {
      thread_local std::vector<std::byte> raw;
      if (segment_.read(id.key(), raw) == 0) return texels;
      if (raw.size() == texels.bytes.size())
        decode_texels(raw, texels);
      else
        ++*damaged_;
    } catch (const std::exception&) {
      ++*damaged_;
    }
    return texels;
  }

 private:
  const SegmentReader& segment_;
  RasterShape shape_;
  std::atomic<std::uint64_t>* damaged_;
};

}  // namespace

std::string raster_params(const RasterShape& s, const std::string& heading) {
  return fmt::format("{}{}{} {} {} {} {} {} {}\n", heading, kShapeWord, s.width, s.height, s.levels,
                     s.tile_size, s.channels, s.texels_per_post_log2, s.fill);
}

std::optional<RasterShape> parse_raster_params(const std::string& params) {
  const std::size_t at = params.rfind(kShapeWord);
  if (at == std::string::npos) return std::nullopt;
  const char* p = params.data() + at + kShapeWord.size();
  const char* const end = params.data() + params.size();
  const auto number = [&](auto& value) {
    while (p != end && *p == ' ') ++p;
    const auto [next, error] = std::from_chars(p, end, value);
    p = next;
    return error == std::errc{};
  };
  RasterShape s;
  const bool whole = number(s.width) && number(s.height) && number(s.levels) &&
                     number(s.tile_size) && number(s.channels) && number(s.texels_per_post_log2) &&
                     number(s.fill);
  if (!whole || !is_sane(s)) return std::nullopt;
  return s;
}

std::unique_ptr<RasterSource> open_raster(const SegmentReader& segment,
                                          std::atomic<std::uint64_t>* damaged) {
  const auto shape = parse_raster_params(segment.params());
  if (!shape)
    throw Error(ErrorCode::Corrupt,
                segment.label() + ": holds no raster pyramid: rebuild the store");
  return std::make_unique<StoredRaster>(segment, *shape, damaged);
}

Texels filled_tile(const RasterShape& shape) {
  const auto side = static_cast<std::size_t>(shape.tile_size);
  const std::size_t bytes = side * side * static_cast<std::size_t>(shape.channels);
  return {shape.tile_size, shape.channels, std::vector<std::uint8_t>(bytes, shape.fill)};
}

void encode_texels(const Texels& texels, std::vector<std::byte>& raw) {
  const auto side = static_cast<std::size_t>(texels.size);
  const auto channels = static_cast<std::size_t>(texels.channels);
  raw.resize(texels.bytes.size());
  for (std::size_t k = 0; k < channels; ++k) {
    std::uint8_t above = 0;
    for (std::size_t r = 0; r < side; ++r) {
      const std::uint8_t* in = texels.bytes.data() + r * side * channels + k;
      std::byte* out = raw.data() + (k * side + r) * side;
      std::uint8_t west = above;
      above = in[0];
      for (std::size_t c = 0; c < side; ++c) {
        const std::uint8_t here = in[c * channels];
        out[c] = static_cast<std::byte>(here - west);
        west = here;
      }
    }
  }
}

void decode_texels(std::span<const std::byte> raw, Texels& texels) {
  const auto side = static_cast<std::size_t>(texels.size);
  const auto channels = static_cast<std::size_t>(texels.channels);
  for (std::size_t k = 0; k < channels; ++k) {
    std::uint8_t above = 0;
    for (std::size_t r = 0; r < side; ++r) {
      const std::byte* in = raw.data() + (k * side + r) * side;
      std::uint8_t* out = texels.bytes.data() + r * side * channels + k;
      std::uint8_t west = above;
      for (std::size_t c = 0; c < side; ++c) {
        west = static_cast<std::uint8_t>(west + std::to_integer<std::uint8_t>(in[c]));
        out[c * channels] = west;
      }
      above = out[0];
    }
  }
}

}  // namespace arete::store
