// The picture on the printer's display, for any number of readers: asked for at most once a second. Event
// loop's thread only.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "daemon/web/printer/control_link.hpp"

namespace contourd::web {

class MaskPicture {
 public:
  using Json = ControlLink::Json;
  // Gets a PNG file; or no bytes, and the "error" of contourd's answer.
  using Fetched = std::function<void(const std::string& png, const Json& error)>;

  static constexpr std::chrono::seconds kFresh{1};
  static constexpr std::size_t kMostBytes = std::size_t{8} << 20U;
  static constexpr int kNoPicture = -32097;  // the error's code if contourd sends no picture

  // The link must outlive the object.
  explicit MaskPicture(ControlLink& printer) : printer_(printer) {}
  MaskPicture(const MaskPicture&) = delete;
  MaskPicture& operator=(const MaskPicture&) = delete;

  // Calls `fetched` exactly once, at once or later.
  void fetch(Fetched fetched);

 private:
  void ask(Json parameters);
  void take(const Json& answer);
  void finish(std::string png, Json error);

  ControlLink& printer_;
  std::vector<Fetched> waiting_;
  std::string bytes_;  // the picture that is being fetched
  std::string latest_;
  Json latest_error_;
  std::chrono::steady_clock::time_point fetched_{};
};

}  // namespace contourd::web
