#include <random>

#include "arete/core/error.h"
#include "arete/store/format.h"
#include "arete/store/segment_reader.h"
#include "arete/store/terrain.h"

#include "store/memory_file.h"
#include "store/store_fixture.h"

namespace arete::store {
namespace {

using Bytes = std::vector<char>;
using Blocks = std::map<std::uint64_t, std::vector<std::byte>>;

std::unique_ptr<SegmentReader> open_bytes(const Bytes& bytes, Verify verify) {
  return std::make_unique<SegmentReader>(std::make_unique<MemoryFile>(bytes), "memory", verify);
}

Blocks read_blocks(const SegmentReader& segment) {
  Blocks blocks;
  for (const std::uint64_t key : segment.keys()) segment.read(key, blocks[key]);
  return blocks;
}

// True when the damaged bytes open and give a block that was never written, without an Error.
bool is_silently_wrong(const Bytes& damaged, const Blocks& written, Verify verify) {
  try {
    const auto segment = open_bytes(damaged, verify);
    if (segment->keys().size() != written.size()) return true;
    for (const auto& [key, block] : written) {
      std::vector<std::byte> raw;
      try {
        if (segment->read(key, raw) == 0 || raw != block) return true;
      } catch (const Error&) {
        continue;
      }
    }
  } catch (const Error&) {
    return false;
  }
  return false;
}

class Damage : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    Heightfield field = make_hills(300, 280, 5);
    punch_holes(field, 2, 3);
    bytes_ = read_all_files(build_store(folder_, field))[std::string(GetParam()) + ".seg"];
    written_ = read_blocks(*open_bytes(bytes_, Verify::Pages));
    ASSERT_FALSE(written_.empty());
  }

  // Flips sampled single bits of bytes [from, end); returns how many gave wrong blocks in silence.
  int count_wrong_flips(int samples, std::size_t from, std::size_t end, Verify verify) {
    std::mt19937_64 random(17);
    int wrong = 0;
    for (int i = 0; i < samples; ++i) {
      Bytes damaged = bytes_;
      const std::uint64_t bit = from * 8 + random() % ((end - from) * 8);
      damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << (bit % 8)));
      wrong += is_silently_wrong(damaged, written_, verify) ? 1 : 0;
    }
    return wrong;
  }

  TemporaryFolder folder_;
  Bytes bytes_;
  Blocks written_;
};

TEST_P(Damage, NoBitFlipIsSilent) {
  EXPECT_EQ(count_wrong_flips(1500, 0, bytes_.size(), Verify::Pages), 0);
  EXPECT_EQ(count_wrong_flips(300, kPageBytes, kPageBytes + 100, Verify::Pages), 0);
}

// Negative control: without verification the same flips must be found to do harm.
TEST_P(Damage, WithoutHashesFlipsAreSilent) {
  EXPECT_GT(count_wrong_flips(300, kPageBytes, kPageBytes + 100, Verify::Nothing), 0);
}

TEST_P(Damage, EveryTruncationIsRefused) {
  for (std::size_t n = 0; n < bytes_.size(); n += 512) {
    const Bytes cut(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(n));
    EXPECT_THROW(open_bytes(cut, Verify::Pages), Error) << n;
  }
}

TEST_P(Damage, SwappedPagesAreNotSilent) {
  const std::size_t pages = bytes_.size() / kPageBytes;
  std::mt19937 random(2);
  for (int i = 0; i < 300; ++i) {
    const auto a = static_cast<std::ptrdiff_t>(random() % pages * kPageBytes);
    const auto b = static_cast<std::ptrdiff_t>(random() % pages * kPageBytes);
    Bytes damaged = bytes_;
    std::swap_ranges(damaged.begin() + a, damaged.begin() + a + kPageBytes, damaged.begin() + b);
    if (damaged == bytes_) continue;
    EXPECT_FALSE(is_silently_wrong(damaged, written_, Verify::Pages)) << a << ", " << b;
    EXPECT_THROW(open_bytes(damaged, Verify::Pages)->check_all(), Error);
  }
}

TEST_P(Damage, UnknownFeaturesAndVersionsAreRefused) {
  Page page;
  std::memcpy(page.data(), bytes_.data(), page.size());
  const SegmentHeader good = decode_header(page, bytes_.size(), "memory");
  const auto code_of = [&](const SegmentHeader& header) {
    Bytes changed = bytes_;
    const Page sealed = encode_header(header);
    std::memcpy(changed.data(), sealed.data(), sealed.size());
    try {
      open_bytes(changed, Verify::Pages);
    } catch (const Error& error) {
      return error.code();
    }
    return ErrorCode::Usage;
  };
  SegmentHeader required = good;
  required.required_features = std::uint64_t{1} << 63U;
  EXPECT_EQ(code_of(required), ErrorCode::Unsupported);
  SegmentHeader newer = good;
  newer.version_major = kVersionMajor + 1;
  EXPECT_EQ(code_of(newer), ErrorCode::Unsupported);
  SegmentHeader huge = good;
  huge.block_count = ~std::uint64_t{0} / 2;
  EXPECT_EQ(code_of(huge), ErrorCode::Corrupt);
}

INSTANTIATE_TEST_SUITE_P(Segments, Damage, testing::Values("heights", "normals", "mask"));

TEST(DamageTest, EveryFlippedByteOfTheManifestIsRefused) {
  Heightfield field = make_hills(40, 30, 5);
  TemporaryFolder folder;
  const auto path = build_store(folder, field);
  const auto files = read_all_files(path);
  const std::size_t size = files.at("manifest.json").size();
  for (std::size_t i = 0; i < size; ++i) {
    OpenOptions options;
    options.prefetch = false;
    options.open = [&](const std::filesystem::path& file) {
      Bytes bytes = files.at(file.filename().string());
      if (file.extension() == ".json") bytes[i] = static_cast<char>(bytes[i] ^ (1 << (i % 8)));
      return std::make_unique<MemoryFile>(bytes);
    };
    EXPECT_THROW(Terrain::open(path, options), Error) << i;
  }
}

TEST(DamageTest, SegmentsOfAnotherStoreAreRefused) {
  TemporaryFolder one;
  TemporaryFolder two;
  Heightfield field = make_hills(140, 140, 1);
  Heightfield other = make_hills(140, 140, 2);
  const auto path = build_store(one, field);
  std::filesystem::copy_file(build_store(two, other) / "heights.seg", path / "heights.seg",
                             std::filesystem::copy_options::overwrite_existing);
  EXPECT_THROW(Terrain::open(path), Error);
}

}  // namespace
}  // namespace arete::store
