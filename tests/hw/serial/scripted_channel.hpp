// A serial line with a made-up projector at its end, on a virtual clock. Not thread-safe.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hw/serial/byte_channel.hpp"
#include "hw/virtual_clock.hpp"

namespace contourd::testing {

class ScriptedChannel final : public ByteChannel {
 public:
  explicit ScriptedChannel(VirtualClock& clock) : clock_(clock) {}

  // The projector's reaction to each message that is sent to it.
  std::function<void(const std::string& message)> projector = [](const std::string&) {};

  // Sends bytes as the projector, after `delay`.
  void send(std::string bytes, Duration delay = std::chrono::milliseconds{20}) {
    timers_.push_back(clock_.call_after(delay, [this, bytes = std::move(bytes)] {
      if (listener_.bytes) listener_.bytes(bytes);
    }));
  }
  void unplug() {
    plugged_ = false;
    if (listener_.lost) listener_.lost("the serial port /dev/ttyUSB7 was lost: it was unplugged");
  }

  struct Sent {
    TimePoint at;
    std::string message;
  };
  std::vector<Sent> sent;
  [[nodiscard]] std::vector<std::string> messages() const {
    std::vector<std::string> all;
    for (const Sent& one : sent)
      all.push_back(one.message);
    return all;
  }

  [[nodiscard]] const std::string& name() const override { return name_; }
  void listen(Listener listener) override { listener_ = std::move(listener); }
  [[nodiscard]] bool write(std::string_view bytes) noexcept override {
    if (!plugged_) return false;
    sent.push_back({clock_.now(), std::string(bytes)});
    projector(sent.back().message);
    return true;
  }
  void write_and_wait(std::string_view bytes, Duration) noexcept override {
    if (!bytes.empty()) last_words.emplace_back(bytes);
  }
  [[nodiscard]] int descriptor() const noexcept override { return -1; }
  std::vector<std::string> last_words;  // sent by write_and_wait()

 private:
  VirtualClock& clock_;
  std::string name_ = "/dev/ttyUSB7";
  Listener listener_;
  bool plugged_ = true;
  std::deque<std::unique_ptr<Timer>> timers_;
};

}  // namespace contourd::testing
