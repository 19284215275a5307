#include "daemon/web/printer/mask_picture.hpp"

#include <cstdint>
#include <optional>
#include <utility>

#include "daemon/system/base64.hpp"

namespace contourd::web {

using Json = ControlLink::Json;

void MaskPicture::fetch(Fetched fetched) {
  const auto now = std::chrono::steady_clock::now();
  if (waiting_.empty() && fetched_ != decltype(fetched_){} && now - fetched_ < kFresh)
    return fetched(latest_, latest_error_);
  waiting_.push_back(std::move(fetched));
  if (waiting_.size() > 1) return;
  bytes_.clear();
  ask(Json::object());
}

void MaskPicture::ask(Json parameters) {
  printer_.call({"mask", std::move(parameters)}, [this](const Json& answer) { take(answer); });
}

void MaskPicture::take(const Json& answer) {
  if (!answer.contains("result")) return finish({}, answer.value("error", Json::object()));
  const Json& piece = answer["result"];
  const std::optional<std::vector<std::uint8_t>> data = from_base64(piece.value("data", ""));
  const std::size_t whole = piece.value("bytes", std::size_t{0});
  if (!data || data->empty() || whole > kMostBytes)
    return finish({}, {{"code", kNoPicture}, {"message", "contourd has sent no picture"}});
  bytes_.append(data->begin(), data->end());
  if (bytes_.size() >= whole) return finish(std::exchange(bytes_, {}), {});
  ask({{"picture", piece["picture"]}, {"from", bytes_.size()}});
}

void MaskPicture::finish(std::string png, Json error) {
  latest_ = std::move(png);
  latest_error_ = std::move(error);
  fetched_ = std::chrono::steady_clock::now();
  for (const Fetched& fetched : std::exchange(waiting_, {}))
    fetched(latest_, latest_error_);
}

}  // namespace contourd::web
