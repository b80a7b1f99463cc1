#include "quantities.h"

#include <cctype>
#include <charconv>
#include <cmath>
#include <optional>
#include <system_error>

#include <fmt/format.h>

namespace arete::app {
namespace {

/// The number that `text` begins with, which is then cut off; nothing when there is none.
template <typename Number>
std::optional<Number> take_number(std::string_view& text) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{}) {
    return std::nullopt;
  }
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return number;
}

/// 1024^k for a suffix such as "K", "KB" or "KiB"; nothing for anything else.
std::optional<double> unit_of(std::string_view suffix) {
  if (suffix.empty() || suffix == "B" || suffix == "b") {
    return 1.0;
  }
  const auto k = std::string_view("KMGT").find(
      static_cast<char>(std::toupper(static_cast<unsigned char>(suffix[0]))));
  const std::string_view rest = suffix.substr(1);
  if (k == std::string_view::npos || !(rest.empty() || rest == "B" || rest == "iB")) {
    return std::nullopt;
  }
  return std::pow(1024.0, static_cast<double>(k + 1));
}

}  // namespace

double Tolerance::pixels(int viewport_height) const {
  return percent ? value / 100 * viewport_height : value;
}

bool parse(std::string_view text, Bytes& bytes) {
  const auto number = take_number<double>(text);
  const auto unit = unit_of(text);
  if (!number || !unit || !(*number > 0) || *number * *unit > 0x1p62) {
    return false;
  }
  bytes.count = static_cast<std::size_t>(*number * *unit);
  return bytes.count > 0;
}

bool parse(std::string_view text, FrameSize& size) {
  constexpr int kLargest = 16384;
  const auto width = take_number<int>(text);
  if (!width || text.empty() || text[0] != 'x') {
    return false;
  }
  text.remove_prefix(1);
  const auto height = take_number<int>(text);
  if (!height || !text.empty() || *width < 1 || *height < 1 || *width > kLargest ||
      *height > kLargest) {
    return false;
  }
  size = {*width, *height};
  return true;
}

bool parse(std::string_view text, Tolerance& tolerance) {
  const auto number = take_number<double>(text);
  if (!number || !(*number > 0) || !std::isfinite(*number) || !(text.empty() || text == "%")) {
    return false;
  }
  tolerance = {*number, text == "%"};
  return true;
}

std::string bytes_text(double bytes) {
  constexpr std::string_view kUnits[] = {"B", "KiB", "MiB", "GiB", "TiB"};
  std::size_t k = 0;
  for (; bytes >= 1024 && k + 1 < std::size(kUnits); ++k) {
    bytes /= 1024;
  }
  return k == 0 ? fmt::format("{:.0f} B", bytes) : fmt::format("{:.1f} {}", bytes, kUnits[k]);
}

std::string grouped(unsigned long long count) {
  std::string digits = fmt::format("{}", count);
  for (auto at = static_cast<int>(digits.size()) - 3; at > 0; at -= 3) {
    digits.insert(static_cast<std::size_t>(at), ",");
  }
  return digits;
}

}  // namespace arete::app
