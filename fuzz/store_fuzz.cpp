// libFuzzer target: any bytes as a segment file, all of its blocks as height tiles.
// Hashes would stop the fuzzer at the gate: page hashes are off, header and footer are mended.
#include <algorithm>
#include <cstring>
#include <memory>
#include <vector>

#include "arete/core/error.h"
#include "arete/store/format.h"
#include "arete/store/height_codec.h"
#include "arete/store/raster_pyramid.h"
#include "arete/store/segment_reader.h"

namespace {

using namespace arete::store;

class FuzzedFile : public File {
 public:
  explicit FuzzedFile(std::vector<std::byte> bytes) : bytes_(std::move(bytes)) {}
  std::uint64_t size() const override { return bytes_.size(); }
  void read_at(std::uint64_t offset, std::span<std::byte> out) const override {
    if (offset > bytes_.size() || out.size() > bytes_.size() - offset)
      throw arete::Error(arete::ErrorCode::Corrupt, "past the end");
    std::ranges::copy(std::span(bytes_).subspan(offset, out.size()), out.begin());
  }

 private:
  std::vector<std::byte> bytes_;
};

// Places of fields in the header page; docs/format.md.
constexpr std::size_t kFileBytesAt = 32, kPageTableAt = 72;

// Header and footer made to agree, so that the fuzzer reaches what lies behind their hashes.
void repair(std::span<std::byte> file) {
  const std::uint64_t size = file.size();
  const auto header = file.first(kPageBytes);
  std::memcpy(header.data() + kFileBytesAt, &size, sizeof size);
  SegmentFooter footer;
  footer.file_bytes = size;
  footer.header_hash = hash64(header.first(kPageBytes - sizeof size));
  std::memcpy(header.data() + kPageBytes - sizeof size, &footer.header_hash, sizeof size);
  std::memcpy(&footer.page_table_offset, header.data() + kPageTableAt, sizeof size);
  if (footer.page_table_offset > size - kPageBytes) return;
  footer.page_table_hash =
      hash64(file.subspan(footer.page_table_offset, size - kPageBytes - footer.page_table_offset));
  const Page sealed = encode_footer(footer);
  std::memcpy(file.last(kPageBytes).data(), sealed.data(), sealed.size());
}

void read_everything(std::vector<std::byte> bytes) {
  const SegmentReader segment(std::make_unique<FuzzedFile>(std::move(bytes)), "fuzz",
                              Verify::Nothing);
  parse_raster_params(segment.params());
  for (const std::uint64_t key : segment.keys()) {
    try {
      std::vector<std::byte> raw;
      HeightTile tile;
      segment.read(key, raw);
      decode_tile(raw, tile);
    } catch (const arete::Error&) {
      continue;
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto input = std::as_bytes(std::span(data, size));
  HeightTile tile;
  try {
    decode_tile(input, tile);
  } catch (const arete::Error&) {
    tile = {};
  }
  std::vector<std::byte> bytes(input.begin(), input.end());
  if (bytes.size() >= 3 * kPageBytes) repair(bytes);
  try {
    read_everything(std::move(bytes));
  } catch (const arete::Error&) {
    return 0;  // refused, as it should be
  }
  return 0;
}
