// The picture on the printer's display, for any number of readers: asked for at most once a second. Event
// loop's thread only.
#pragma once

#include <chrono>
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

  // The link must outlive the object.
  explicit MaskPicture(ControlLink& printer) : printer_(printer) {}
  MaskPicture(const MaskPicture&) = delete;
  MaskPicture& operator=(const MaskPicture&) = delete;

  // Calls `fetched` exactly once, at once or later.
  void fetch(Fetched fetched);

 private:
  void finish(std::string png, Json error);

  ControlLink& printer_;
  std::vector<Fetched> waiting_;
  std::string latest_;
  Json latest_error_;
  std::chrono::steady_clock::time_point fetched_{};
};

}  // namespace contourd::web
