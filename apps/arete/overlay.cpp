#include "overlay.h"

#include <algorithm>

#include <fmt/format.h>
#include <imgui.h>

#include "quantities.h"

namespace arete::app {
namespace {

template <typename... Values>
void line(fmt::format_string<Values...> format, Values&&... values) {
  const std::string text = fmt::format(format, std::forward<Values>(values)...);
  ImGui::TextUnformatted(text.data(), text.data() + text.size());
}

std::string against(double bytes, std::size_t budget) {
  return fmt::format("{} of {}", bytes_text(bytes), bytes_text(static_cast<double>(budget)));
}

void draw_times(const FrameTimes& times) {
  line("{:.0f} frames/s, {:.1f} ms (worst {:.1f})", 1000 / std::max(times.mean_ms(), 1e-3F),
       times.mean_ms(), times.max_ms());
  ImGui::PlotLines("##times", times.ring().data(), static_cast<int>(times.ring().size()),
                   times.next(), nullptr, 0, std::max(33.0F, times.max_ms()), ImVec2(300, 40));
}

void draw_counts(const OverlayText& text) {
  line("triangles        {}", grouped(text.refine.triangles));
  line("errors projected {}", grouped(text.refine.evaluated_vertices));
  line("cache            {}",
       against(static_cast<double>(text.cache.resident_bytes), text.cache_budget));
  line("GPU              {}", against(static_cast<double>(text.draw.gpu_bytes), text.gpu_budget));
  line("achieved error   {:.2f} px{}", text.refine.achieved_error_px,
       text.refine.late_blocks != 0 ? fmt::format(" ({} tiles coming)", text.refine.late_blocks)
                                    : "");
  if (text.draw.dropped_batches != 0) {
    line("{} batches do not fit --gpu-memory", text.draw.dropped_batches);
  }
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

void draw_overlay(const OverlayText& text, const FrameTimes& times, float& tolerance_px) {
  ImGui::SetNextWindowPos(ImVec2(10, 10), ImGuiCond_FirstUseEver);
  ImGui::SetNextWindowBgAlpha(0.7F);
  ImGui::Begin("Arete", nullptr,
               ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoFocusOnAppearing |
                   ImGuiWindowFlags_NoNav);
  line("{}, {}{}", text.method, text.mode, text.frozen ? ", LOD frozen" : "");
  draw_times(times);
  draw_counts(text);
  ImGui::SetNextItemWidth(180);
  ImGui::SliderFloat("tolerance px", &tolerance_px, 0.1F, 32, "%.2f", ImGuiSliderFlags_Logarithmic);
  if (text.under_cursor) {
    line("cursor {:.6g}, {:.6g}: {:.1f} m", text.under_cursor->x, text.under_cursor->y,
         text.under_cursor->z);
  } else {
    line("cursor in the sky");
  }
  line("eye {:.1f} m above ground", text.eye_height);
  line("{}", text.message.empty() ? "H: help" : text.message);
  ImGui::End();
}

void draw_help() {
  constexpr const char* kKeys =
      "Map    left drag pans, right drag or wheel zooms, middle drag turns\n"
      "Fly    W A S D, Q E down and up, drag looks around, Shift faster\n"
      "Both   double click goes there, Space goes home\n"
      "\n"
      "F      map or fly          M      next method\n"
      "W      wireframe (map)     L      freeze the level of detail\n"
      "P      record a path; P again saves and replays it\n"
      "F12    screenshot          H      this help\n"
      "Esc    quit";
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos(ImVec2(size.x / 2, size.y / 2), ImGuiCond_Always, ImVec2(0.5F, 0.5F));
  ImGui::Begin("Help", nullptr,
               ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse |
                   ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoNav);
  ImGui::TextUnformatted(kKeys);
  ImGui::End();
}

}  // namespace arete::app
