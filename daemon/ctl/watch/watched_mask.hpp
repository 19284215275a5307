// The mask that contourd's display shows, for a view: asked for piece by piece, once a layer at most, and
// only while there is room to show it; drawn below the view's text. It knows no connection. Not thread-safe.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/mask/mask.hpp"
#include "daemon/ctl/terminal/terminal_picture.hpp"
#include "daemon/ctl/watch/watch_view.hpp"

namespace contourd::ctl {

class WatchedMask {
 public:
  using Json = nlohmann::ordered_json;
  using Time = std::chrono::steady_clock::time_point;

  // The number of its questions; answers have it, too.
  static constexpr int kQuestion = 100;
  // From one picture's first question to the next one's, at least: a simulated printer's layers are faster.
  static constexpr std::chrono::seconds kInterval{2};

  explicit WatchedMask(PictureInk ink) : ink_(ink) {}

  // What is on the screen by this status.
  void note(const Json& status);
  // The parameters of `mask` for what is missing, to be sent now; nothing when nothing is to be asked.
  [[nodiscard]] std::optional<Json> question(Time now);
  // An answer to that. Any other message is no matter.
  void take(const Json& message);
  // What is under way is not answered any more.
  void connection_lost();

  // At most so many lines; none where there is nothing to show, or too little room.
  [[nodiscard]] const std::vector<ScreenLine>& lines(ScreenSize room);

 private:
  struct Picture {
    std::uint64_t number = 0;
    std::size_t bytes = 0;
    std::int32_t width = 0, height = 0;
    std::string caption;
    std::vector<std::uint8_t> png;  // as far as it has come
  };

  void take_piece(const Json& reply);
  void draw(ScreenSize room);

  PictureInk ink_;
  std::string on_screen_, asked_for_;  // which mask: a name for each; empty: none
  bool has_room_ = false;
  bool waits_ = false;  // for an answer
  std::optional<Picture> arriving_;
  Time next_{};
  Mask mask_;
  std::string caption_;
  std::vector<ScreenLine> drawn_;
  ScreenSize drawn_for_{0, 0};
};

}  // namespace contourd::ctl
