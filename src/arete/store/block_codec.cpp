#include "arete/store/block_codec.h"

#include <algorithm>
#include <memory>
#include <new>

#include <zstd.h>

namespace arete::store {
namespace {

constexpr int kZstdLevel = 1;

// Contexts are large and slow to make; one a thread serves all blocks.
ZSTD_CCtx* compressor() {
  thread_local const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(),
                                                                                  &ZSTD_freeCCtx);
  if (!context) throw std::bad_alloc();
  return context.get();
}

ZSTD_DCtx* decompressor() {
  thread_local const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(),
                                                                                  &ZSTD_freeDCtx);
  if (!context) throw std::bad_alloc();
  return context.get();
}

}  // namespace

std::size_t compress_block(std::span<const std::byte> raw, std::vector<std::byte>& out) {
  const std::size_t start = out.size();
  out.resize(start + ZSTD_compressBound(raw.size()));
  std::size_t stored = ZSTD_compressCCtx(compressor(), out.data() + start, out.size() - start,
                                         raw.data(), raw.size(), kZstdLevel);
  if (ZSTD_isError(stored) != 0 || stored >= raw.size()) {
    std::ranges::copy(raw, out.begin() + static_cast<std::ptrdiff_t>(start));
    stored = raw.size();
  }
  out.resize(start + stored);
  return stored;
}

bool decompress_block(std::span<const std::byte> stored, std::span<std::byte> raw) {
  if (stored.size() > raw.size()) return false;
  if (stored.size() == raw.size()) {
    std::ranges::copy(stored, raw.begin());
    return true;
  }
  const std::size_t n =
      ZSTD_decompressDCtx(decompressor(), raw.data(), raw.size(), stored.data(), stored.size());
  return ZSTD_isError(n) == 0 && n == raw.size();
}

}  // namespace arete::store
