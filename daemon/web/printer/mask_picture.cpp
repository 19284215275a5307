#include "daemon/web/printer/mask_picture.hpp"

#include <utility>

#include "daemon/web/printer/fetched_file.hpp"

namespace contourd::web {

void MaskPicture::fetch(Fetched fetched) {
  const auto now = std::chrono::steady_clock::now();
  if (waiting_.empty() && fetched_ != decltype(fetched_){} && now - fetched_ < kFresh)
    return fetched(latest_, latest_error_);
  waiting_.push_back(std::move(fetched));
  if (waiting_.size() > 1) return;
  fetch_file(printer_, {.method = "mask"},
             [this](std::string png, const Json& error) { finish(std::move(png), error); });
}

void MaskPicture::finish(std::string png, Json error) {
  latest_ = std::move(png);
  latest_error_ = std::move(error);
  fetched_ = std::chrono::steady_clock::now();
  for (const Fetched& fetched : std::exchange(waiting_, {}))
    fetched(latest_, latest_error_);
}

}  // namespace contourd::web
