#include "daemon/web/printer/control_link.hpp"

#include <sys/epoll.h>

#include <exception>
#include <utility>

namespace contourd::web {
namespace {

constexpr std::string_view kLinkName = "the connection to contourd";
constexpr std::chrono::seconds kConnectPatience{1};

}  // namespace

void ControlLink::call(Request request, Answer answer) {
  if (calls_.size() >= kMostCalls)
    return fail_later(std::move(answer), "too many requests wait for contourd; try again");
  calls_.push_back({std::move(request), std::move(answer)});
  send_next();
}

void ControlLink::send_next() {
  if (asked_ || calls_.empty()) return;
  try {
    if (!connection_) {
      connection_ = std::make_unique<DaemonConnection>(socket_, kConnectPatience);
      source_ =
          loop_.on_ready(connection_->descriptor(), EPOLLIN, kLinkName, [this](std::uint32_t) { receive(); });
    }
    connection_->send(calls_.front().request.method, ++number_, calls_.front().request.parameters);
    asked_ = true;
    patience_timer_ = loop_.at(std::chrono::steady_clock::now() + patience_, kLinkName, [this] {
      close("contourd does not answer: see \"systemctl status contourd\"");
    });
  } catch (const DaemonError& error) {
    close(error.what());
  }
}

void ControlLink::receive() {
  try {
    while (connection_) {
      const std::optional<Json> message = connection_->receive_until(std::chrono::steady_clock::now());
      if (!message) return;
      take(*message);
    }
  } catch (const std::exception& error) {
    close(error.what());
  }
}

void ControlLink::take(const Json& message) {
  if (!message.contains("id")) {
    if (notified_) notified_(message);
    return;
  }
  if (!asked_ || message["id"] != number_) return;
  asked_ = false;
  patience_timer_.reset();
  const Call call = std::move(calls_.front());
  calls_.pop_front();
  call.answer(message);
  send_next();
}

void ControlLink::close(const std::string& why) {
  source_.reset();
  connection_.reset();
  patience_timer_.reset();
  asked_ = false;
  for (Call& call : std::exchange(calls_, {}))
    fail_later(std::move(call.answer), why);
}

void ControlLink::fail_later(Answer answer, std::string why) {
  failed_.emplace_back(std::move(answer), std::move(why));
  fail_timer_ = loop_.at(std::chrono::steady_clock::now(), kLinkName, [this] {
    for (const auto& [failed, reason] : std::exchange(failed_, {}))
      failed(Json{{"error", {{"code", kUnreachable}, {"message", reason}}}});
  });
}

}  // namespace contourd::web
