// The mask on contourd's display, drawn below the view's text. It is requested piece by piece, at most once
// per layer, and only while there is room to show it. The caller owns the connection. Not thread-safe.
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

  // Number of the requests, which their answers repeat.
  static constexpr int kQuestion = 100;
  // Minimum interval between two pictures, because a simulated printer can have faster layers.
  static constexpr std::chrono::seconds kInterval{2};

  explicit WatchedMask(PictureInk ink) : ink_(ink) {}

  // Notes from a status which mask is on the display.
  void note(const Json& status);
  // Returns the parameters of the next request of `mask`, or nullopt if no request is due.
  [[nodiscard]] std::optional<Json> question(Time now);
  // Handles an answer to such a request. Ignores other messages.
  void take(const Json& message);
  // Forgets the request that will not be answered any more.
  void connection_lost();

  // Returns the part of the screen for the text above the mask. A third of the rows is for the mask while
  // there is one and it can be recognised in so few rows; the mask also gets the rows that the text leaves
  // free.
  [[nodiscard]] ScreenSize room_for_text(ScreenSize screen) const;
  // Returns lines that fit into the room; none if there is no mask or too little room.
  [[nodiscard]] const std::vector<ScreenLine>& lines(ScreenSize room);

 private:
  struct Picture {
    std::uint64_t number = 0;
    std::size_t bytes = 0;
    std::int32_t width = 0, height = 0;
    std::string caption;
    std::vector<std::uint8_t> png;  // the bytes received so far
  };

  void take_piece(const Json& reply);
  void draw(ScreenSize room);

  PictureInk ink_;
  std::string on_screen_, asked_for_;  // names of masks; empty: none
  bool has_room_ = false;
  bool waits_ = false;  // a request is unanswered
  std::optional<Picture> arriving_;
  Time next_{};
  Mask mask_;
  std::string caption_;
  std::vector<ScreenLine> drawn_;
  ScreenSize drawn_for_{0, 0};
};

}  // namespace contourd::ctl
