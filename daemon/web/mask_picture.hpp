// The picture on the printer's display, for any number of pages: asked for at most once a second. Event
// loop's thread only.
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "daemon/web/control_link.hpp"
#include "daemon/web/http_request.hpp"

namespace contourd::web {

class MaskPicture {
 public:
  static constexpr std::chrono::seconds kFresh{1};
  static constexpr std::size_t kMostBytes = std::size_t{8} << 20U;

  // The link must outlive the object.
  explicit MaskPicture(ControlLink& printer) : printer_(printer) {}
  MaskPicture(const MaskPicture&) = delete;
  MaskPicture& operator=(const MaskPicture&) = delete;

  // Answers with a PNG file; with 404 and a sentence if nothing is shown.
  void serve(const std::shared_ptr<HttpRequest>& request);

 private:
  void ask(ControlLink::Json parameters);
  void take(const ControlLink::Json& answer);
  void answer_all(const HttpReply& reply);

  ControlLink& printer_;
  std::vector<std::shared_ptr<HttpRequest>> waiting_;
  std::string bytes_;  // the picture that is being fetched
  HttpReply latest_;
  std::chrono::steady_clock::time_point fetched_{};
};

}  // namespace contourd::web
