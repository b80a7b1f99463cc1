#include "overlay.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <imgui.h>

#include "quantities.h"

namespace arete::app {
namespace {

constexpr float kWidth = 330;
constexpr float kLabelWidth = 84;
const ImVec4 kDim{0.62F, 0.67F, 0.73F, 1};
const ImVec4 kBright{0.95F, 0.97F, 1.0F, 1};
const ImVec4 kAmber{1.0F, 0.72F, 0.28F, 1};
const ImVec4 kRed{1.0F, 0.45F, 0.40F, 1};
const ImVec4 kBlue{0.27F, 0.55F, 0.80F, 1};
constexpr ImGuiWindowFlags kPanel = ImGuiWindowFlags_AlwaysAutoResize |
                                    ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoNav |
                                    ImGuiWindowFlags_NoSavedSettings;

void say(const std::string& text, const ImVec4& colour = kBright) {
  ImGui::PushStyleColor(ImGuiCol_Text, colour);
  ImGui::TextUnformatted(text.data(), text.data() + text.size());
  ImGui::PopStyleColor();
}

void label(std::string_view name) {
  ImGui::AlignTextToFramePadding();
  say(std::string(name.substr(0, name.find('#'))), kDim);
  ImGui::SameLine(kLabelWidth);
}

void row(const char* name, const std::string& value, const ImVec4& colour = kBright) {
  say(name, kDim);
  ImGui::SameLine(kLabelWidth);
  say(value, colour);
}

/// Bytes held, as a bar whose full length is the budget.
void budget_bar(const char* name, std::uint64_t bytes, std::size_t budget) {
  label(name);
  const float share = budget == 0 ? 0 : static_cast<float>(bytes) / static_cast<float>(budget);
  const std::string text = fmt::format("{} of {}", bytes_text(static_cast<double>(bytes)),
                                       bytes_text(static_cast<double>(budget)));
  ImGui::PushStyleColor(ImGuiCol_PlotHistogram, share > 0.98F ? kAmber : kBlue);
  ImGui::ProgressBar(std::min(share, 1.0F), ImVec2(kWidth - kLabelWidth, 0), text.c_str());
  ImGui::PopStyleColor();
}

std::string length_text(double metres) {
  return metres < 10'000 ? fmt::format("{:.1f} m", metres)
                         : fmt::format("{:.1f} km", metres / 1000);
}

void draw_times(const FrameTimes& times) {
  const float mean = std::max(times.mean_ms(), 1e-3F);
  const std::string text =
      fmt::format("{:.0f} frames/s   {:.1f} ms, worst {:.1f}", 1000 / mean, mean, times.max_ms());
  ImGui::PlotLines("##times", times.ring().data(), static_cast<int>(times.ring().size()),
                   times.next(), text.c_str(), 0, std::max(2 * mean, times.max_ms()),
                   ImVec2(kWidth, 54));
}

std::optional<std::string> choose_method(const OverlayText& text) {
  std::optional<std::string> chosen;
  label("method");
  ImGui::SetNextItemWidth(kWidth - kLabelWidth);
  if (ImGui::BeginCombo("##method", std::string(text.method).c_str())) {
    for (const std::string& method : text.methods) {
      if (ImGui::Selectable(method.c_str(), method == text.method) && method != text.method) {
        chosen = method;
      }
    }
    ImGui::EndCombo();
  }
  return chosen;
}

/// The error, and what stands against the tolerance that was asked for.
void draw_error(const OverlayText& text, float tolerance_px) {
  const RefineStats& stats = text.refine;
  std::string value = fmt::format("{:.2f} px", stats.achieved_error_px);
  const bool capped = stats.tolerance_px > 1.001 * static_cast<double>(tolerance_px);
  if (stats.late_blocks != 0) {
    value += fmt::format(", {} tiles coming", grouped(stats.late_blocks));
  } else if (capped) {
    value += fmt::format(", budget: {:.2f} px", stats.tolerance_px);
  }
  row("error", value, stats.late_blocks != 0 || capped ? kAmber : kBright);
}

void draw_counts(const OverlayText& text) {
  budget_bar("cache", text.cache_bytes, text.cache_budget);
  budget_bar("GPU", text.gpu_bytes, text.gpu_budget);
  if (text.draw.dropped_batches != 0) {
    say(fmt::format("{} batches do not fit the GPU memory", text.draw.dropped_batches), kRed);
  }
  if (text.cache.damaged != 0) {
    say(fmt::format("{} damaged parts are drawn coarser", text.cache.damaged), kRed);
  }
}

constexpr ImGuiSliderFlags kLogSlider = ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp;

/// True once the user lets go.
bool memory_slider(const char* name, int& mib, int least) {
  label(name);
  ImGui::PushID(name);
  ImGui::SetNextItemWidth(kWidth - kLabelWidth);
  ImGui::SliderInt("##mib", &mib, least, 16384, "%d MiB", kLogSlider);
  const bool set = ImGui::IsItemDeactivatedAfterEdit();
  ImGui::PopID();
  return set;
}

bool draw_knobs(Knobs& knobs) {
  label("tolerance");
  ImGui::SetNextItemWidth(kWidth - kLabelWidth);
  ImGui::SliderFloat("##tolerance", &knobs.tolerance_px, 0.1F, 32, "%.2f px", kLogSlider);
  if (!ImGui::TreeNodeEx("budgets", ImGuiTreeNodeFlags_NoTreePushOnOpen)) {
    return false;
  }
  const bool all = knobs.triangles == Knobs::kAllTriangles;
  label("triangles");
  ImGui::SetNextItemWidth(kWidth - kLabelWidth);
  ImGui::SliderInt("##triangles", &knobs.triangles, 1000, Knobs::kAllTriangles,
                   all ? "no limit" : "%d", kLogSlider);
  const bool cache = memory_slider("cache##knob", knobs.cache_mib, 16);
  const bool gpu = memory_slider("GPU##knob", knobs.gpu_mib, 16);
  return cache || gpu;
}

ImVec4 colour_of(Mood mood) {
  return mood == Mood::Failure ? kRed : kBright;
}

}  // namespace

void FrameTimes::add(float ms) {
  ms_[next_] = ms;
  next_ = (next_ + 1) % ms_.size();
  count_ = std::min(count_ + 1, ms_.size());
}

float FrameTimes::mean_ms() const {
  float sum = 0;
  for (const float ms : ms_) {
    sum += ms;
  }
  return count_ == 0 ? 0 : sum / static_cast<float>(count_);
}

float FrameTimes::max_ms() const {
  return *std::ranges::max_element(ms_);
}

void style_overlay() {
  ImGui::StyleColorsDark();
  ImGuiStyle& style = ImGui::GetStyle();
  style.WindowRounding = 6;
  style.FrameRounding = style.GrabRounding = 3;
  style.WindowPadding = ImVec2(12, 10);
  style.ItemSpacing = ImVec2(8, 5);
  style.WindowBorderSize = 0;
  style.Colors[ImGuiCol_WindowBg] = ImVec4(0.05F, 0.07F, 0.10F, 0.78F);
  style.Colors[ImGuiCol_TitleBgActive] = style.Colors[ImGuiCol_TitleBg] =
      style.Colors[ImGuiCol_TitleBgCollapsed] = ImVec4(0.09F, 0.13F, 0.19F, 0.9F);
  style.Colors[ImGuiCol_FrameBg] = ImVec4(0.16F, 0.20F, 0.26F, 0.8F);
  style.Colors[ImGuiCol_PlotLines] = ImVec4(0.55F, 0.80F, 1.0F, 1);
}

Wishes draw_overlay(const OverlayText& text, const FrameTimes& times, Knobs& knobs) {
  ImGui::SetNextWindowPos(ImVec2(12, 12), ImGuiCond_FirstUseEver);
  Wishes wishes;
  if (ImGui::Begin("Arete", nullptr, kPanel)) {
    draw_times(times);
    wishes.method = choose_method(text);
    row("triangles", grouped(text.refine.triangles));
    row("evaluated", grouped(text.refine.evaluated_vertices) + " vertices");
    draw_error(text, knobs.tolerance_px);
    draw_counts(text);
    wishes.memory = draw_knobs(knobs);
    ImGui::Separator();
    row("cursor", text.place);
    row("eye", fmt::format("{} above the ground", length_text(text.eye_height)));
    row("mode",
        fmt::format("{}{}{}", text.mode, text.frozen ? ", detail frozen (L)" : "",
                    text.wireframe ? ", wireframe (W)" : ""),
        text.frozen ? kAmber : kBright);
    say("H  help", kDim);
  }
  ImGui::End();
  return wishes;
}

void draw_notices(const std::vector<Notice>& notices) {
  if (notices.empty()) {
    return;
  }
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos(ImVec2(size.x / 2, size.y - 16), ImGuiCond_Always, ImVec2(0.5F, 1));
  ImGui::SetNextWindowSizeConstraints(ImVec2(0, 0), ImVec2(size.x - 24, size.y));
  ImGui::Begin("##notices", nullptr,
               kPanel | ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs);
  for (const Notice& notice : notices) {
    if (notice.mood == Mood::Working) {
      ImGui::PushStyleColor(ImGuiCol_PlotHistogram, kBlue);
      ImGui::ProgressBar(static_cast<float>(notice.done), ImVec2(140, 0));
      ImGui::PopStyleColor();
      ImGui::SameLine();
    }
    ImGui::PushTextWrapPos(size.x - 48);
    say(notice.text, colour_of(notice.mood));
    ImGui::PopTextWrapPos();
  }
  ImGui::End();
}

void draw_help() {
  constexpr std::pair<const char*, const char*> kHelp[] = {
      {"left drag", "pan: the ground follows the mouse"},
      {"wheel, right drag", "zoom towards the mouse"},
      {"middle drag", "turn about the ground under the mouse"},
      {"double click", "fly there"},
      {"Space", "fly home: the whole terrain"},
      {nullptr, nullptr},
      {"F", "fly, or back to the map"},
      {"W A S D", "flying: forward, left, back, right"},
      {"Q E", "flying: down, up"},
      {"drag", "flying: look around"},
      {"Shift", "flying: five times faster"},
      {nullptr, nullptr},
      {"+ -", "more or less detail (also Page Up, Page Down)"},
      {"M", "next method"},
      {"W", "wireframe, on the map"},
      {"L", "freeze the detail, to fly away from it and look at it"},
      {"P", "replay the path; without one: record, then save and replay it"},
      {"Shift P", "record another path"},
      {"F12", "save a picture"},
      {"H, Esc", "this help, quit"},
      {nullptr, nullptr},
      {"drop a file", "open a store or a DEM"},
  };
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos(ImVec2(size.x / 2, size.y / 2), ImGuiCond_Always, ImVec2(0.5F, 0.5F));
  ImGui::Begin("Help", nullptr, kPanel | ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoMove);
  for (const auto& [key, meaning] : kHelp) {
    if (key == nullptr) {
      ImGui::Separator();
      continue;
    }
    say(key, kAmber);
    ImGui::SameLine(150);
    say(meaning);
  }
  ImGui::End();
}

}  // namespace arete::app
