// An exposure in several pictures, for a display with few grey levels: which picture is on the screen, and
// which one follows when. Pictures are drawn before they are due: the first two before the light goes on,
// each later one in parts when the picture before it is on the screen. Allocates in the constructor only.
// Event loop's thread only.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/mask/light_split.hpp"
#include "core/mask/pixel_map.hpp"
#include "hw/clock.hpp"

namespace contourd {

class SplitExposure {
 public:
  // The shortest time of a picture, in refreshes of the display: one until it appears, and two in which the
  // next one is drawn and written.
  static constexpr int kShortestPicture = 3;

  SplitExposure(const PanelTone& panel, Pixels width, Pixels height);
  [[nodiscard]] const PanelTone& panel() const { return panel_; }
  // Returns the share of an exposure that a picture lasts at least.
  [[nodiscard]] static double shortest_share(Duration exposure, Duration frame) {
    return in_seconds(kShortestPicture * frame) / in_seconds(exposure);
  }
  // Returns the memory in bytes.
  [[nodiscard]] static std::uint64_t memory(const DisplayGeometry& display) {
    return 2 * static_cast<std::uint64_t>(display.width.count()) *
           static_cast<std::uint64_t>(display.height.count());
  }

  struct Times {
    Duration asked;  // light of the whole exposure
    Duration past;   // light that an interrupted exposure was given already
    Duration frame;  // from one refresh of the display to the next
  };
  // Begins the exposure of a mask of linear light, or what is left of it, and returns its first picture. The
  // mask must stay until the next begin(). REQUIRES: the mask has the display's size; asked > 0.
  const Mask& begin(const Mask& light, const Times& times);

  // Return the number of pictures of the whole exposure, and the largest difference of a pixel's share of the
  // light from the one that the mask asks for.
  [[nodiscard]] std::size_t pictures() const { return split_.pictures(); }
  [[nodiscard]] double light_error() const { return split_.error(); }

  // Returns the light, from the beginning of the whole exposure, after which the next picture is due; nullopt
  // if the last one is on the screen.
  [[nodiscard]] std::optional<Duration> next_due() const;
  // Records that the next picture has been on the screen since this much light. The one after it follows; if
  // later ones are due by then, the last of these. REQUIRES: next_due(), and the picture is drawn.
  void shown(Duration lit);
  // Draws a part of the next picture, in a few milliseconds. False if nothing is left to draw.
  bool draw_some();
  // Returns the next picture. Valid until shown() is called for the picture after it. REQUIRES: next_due(),
  // and the picture is drawn.
  [[nodiscard]] const Mask& next() const;

 private:
  [[nodiscard]] Duration due(std::size_t picture) const;
  [[nodiscard]] std::size_t picture_at(Duration lit) const;
  void follow(std::size_t picture, Duration lit);
  [[nodiscard]] std::int32_t height() const { return light_->height().count(); }
  [[nodiscard]] bool is_drawn() const { return next_ && drawn_rows_ == height(); }

  PanelTone panel_;
  LightSplit split_;
  std::array<Mask, 2> pictures_;
  std::size_t on_screen_ = 0;        // of pictures_; the other one is the next picture
  std::optional<std::size_t> next_;  // its number
  std::int32_t drawn_rows_ = 0;      // of the next picture
  const Mask* light_ = nullptr;
  Times times_{};
};

}  // namespace contourd
