#include "daemon/web/mask_picture.hpp"

#include <cstdint>
#include <optional>
#include <utility>

#include "daemon/system/base64.hpp"
#include "daemon/web/printer_answer.hpp"

namespace contourd::web {

using Json = ControlLink::Json;

void MaskPicture::serve(const std::shared_ptr<HttpRequest>& request) {
  const auto now = std::chrono::steady_clock::now();
  if (waiting_.empty() && fetched_ != decltype(fetched_){} && now - fetched_ < kFresh)
    return request->answer(latest_);
  waiting_.push_back(request);
  if (waiting_.size() > 1) return;
  bytes_.clear();
  ask(Json::object());
}

void MaskPicture::ask(Json parameters) {
  printer_.call({"mask", std::move(parameters)}, [this](const Json& answer) { take(answer); });
}

void MaskPicture::take(const Json& answer) {
  if (!answer.contains("result")) {
    HttpReply reply = reply_of(answer);
    if (reply.status == kConflict) reply.status = 404;
    return answer_all(reply);
  }
  const Json& piece = answer["result"];
  const std::optional<std::vector<std::uint8_t>> data = from_base64(piece.value("data", ""));
  const std::size_t whole = piece.value("bytes", std::size_t{0});
  if (!data || data->empty() || whole > kMostBytes)
    return answer_all({.status = 502, .body = "contourd has sent no picture\n"});
  bytes_.append(data->begin(), data->end());
  if (bytes_.size() >= whole) return answer_all({.type = "image/png", .body = std::exchange(bytes_, {})});
  ask({{"picture", piece["picture"]}, {"from", bytes_.size()}});
}

void MaskPicture::answer_all(const HttpReply& reply) {
  latest_ = reply;
  fetched_ = std::chrono::steady_clock::now();
  for (const std::shared_ptr<HttpRequest>& request : std::exchange(waiting_, {}))
    request->answer(reply);
}

}  // namespace contourd::web
