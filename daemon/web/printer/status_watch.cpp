#include "daemon/web/printer/status_watch.hpp"

#include <string_view>
#include <utility>

namespace contourd::web {
namespace {

constexpr std::string_view kWatchName = "the printer's status";
// Notifications come at once; what has none, such as a new file in the queue, is found by asking.
constexpr Duration kAskAgain = std::chrono::seconds(2);

}  // namespace

StatusWatch::StatusWatch(EventLoop& loop, const std::filesystem::path& socket, Told told)
    : loop_(loop), told_(std::move(told)), link_(loop, socket) {
  link_.on_notification([this](const Json& notification) {
    if (running_ && notification.contains("params")) told_(notification["params"]);
  });
}

void StatusWatch::start() {
  if (!std::exchange(running_, true)) ask();
}

void StatusWatch::stop() {
  running_ = false;
  ask_timer_.reset();
  link_.close("no one watches the printer");
}

void StatusWatch::ask() {
  if (!link_.is_connected()) watching_ = false;
  if (!std::exchange(asked_, true))
    link_.call({"status"}, [this](const Json& answer) {
      asked_ = false;
      if (!running_) return;
      if (!answer.contains("result")) return told_({{"unreachable", answer["error"]["message"]}});
      told_(answer["result"]);
      watch();
    });
  ask_timer_ = loop_.at(std::chrono::steady_clock::now() + kAskAgain, kWatchName, [this] { ask(); });
}

void StatusWatch::watch() {
  if (!running_ || std::exchange(watching_, true)) return;
  link_.call({"watch"}, [this](const Json& answer) { watching_ = answer.contains("result"); });
}

}  // namespace contourd::web
