// A model of a projector and its serial line, which knows when the light is really on. Commands and replies
// may be lost, garbled, late or doubled on the line. Not thread-safe.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "hw/serial/byte_channel.hpp"
#include "hw/serial/projector_table.hpp"
#include "hw/virtual_clock.hpp"
#include "tests/models/dice.hpp"

namespace contourd::rig {

using models::Dice;

// Probability of each fault, for each message.
struct LineFaults {
  double command_lost = 0, command_garbled = 0;
  double reply_lost = 0, reply_garbled = 0, reply_late = 0, reply_doubled = 0;
  bool from_light_on = false;  // no faults before the first light on

  [[nodiscard]] bool any() const {
    return command_lost + command_garbled + reply_lost + reply_garbled + reply_late + reply_doubled > 0;
  }
};

struct ProjectorTraits {
  bool answers_light = false;  // the light's state can be queried
  bool echoes = false;
  Duration latency{};         // delay until the light, according to the table
  Duration slower{};          // greatest additional delay of the light
  Duration darkening{};       // greatest delay from the command until it is dark
  Duration thinks{};          // greatest delay from obeying to the reply
  Duration lights_late{};     // greatest additional delay of the reply to light on
  Duration gap{};             // gap according to the table
  Duration warms_up{};        // true warm-up time; the table says 5 s
  bool comes_up_lit = true;   // the light is on once the projector is warm
  bool left_on = false;       // was left on by an earlier program
  bool warming_is_on = true;  // the answer to the power query while the projector warms up
  enum class WhileWarm { Refuses, Silent, Obeys } off_while_warming = WhileWarm::Refuses;
};

// Returns the table with which the daemon drives the projector.
[[nodiscard]] ProjectorTable table_of(const ProjectorTraits& traits, bool switches_light);

class ProjectorModel {
 public:
  // `world` runs in real time, not in the loop's. Both must outlive the model; `changed` is called whenever
  // the light has changed.
  ProjectorModel(VirtualClock& world, const ProjectorTraits& traits, bool switches_light,
                 const LineFaults& faults, std::uint64_t seed);

  std::function<void()> changed = [] {};
  std::function<void(std::string bytes)> answers = [](const std::string&) {};

  // Called with each message on the line, for the log.
  std::function<void(const std::string& what)> tell = [](const std::string&) {};

  // Takes the bytes sent by the computer.
  void receive(const std::string& bytes);

  [[nodiscard]] bool lit() const { return power_ == Power::On && !muted_; }
  [[nodiscard]] bool powered() const { return power_ == Power::On || power_ == Power::Warming; }
  // True if the light is on without a request.
  [[nodiscard]] bool came_up_lit() const { return lit() && !asked_; }
  // Ends all faults.
  void heal() { faults_ = {}; }
  [[nodiscard]] std::uint64_t faults_made() const { return made_; }
  // Returns when the computer last sent light off or power off, even if that was lost.
  [[nodiscard]] TimePoint off_sent() const { return off_sent_; }

 private:
  enum class Power { Off, Warming, On, Cooling };
  enum class Command { PowerOn, PowerOff, LightOn, LightOff, AskPower, AskLight, Unknown };

  [[nodiscard]] Command command_in(const std::string& line) const;
  void take_line(const std::string& line, TimePoint first_byte);
  void obey(Command command, TimePoint came);
  void warm();
  bool reply(const std::string& text, TimePoint sent_at, TimePoint latest);
  void send(std::string bytes, TimePoint when);
  void at(TimePoint when, std::function<void()> call);
  [[nodiscard]] bool happens(double probability) {
    const bool so = dice_.chance(probability) && (light_on_sent_ || !faults_.from_light_on);
    made_ += so ? 1 : 0;
    return so;
  }
  [[nodiscard]] Duration wire_time(std::size_t bytes) const;

  VirtualClock& world_;
  ProjectorTraits traits_;
  ProjectorTable table_;
  LineFaults faults_;
  Dice dice_;
  std::uint64_t made_ = 0;
  Power power_ = Power::Off;
  bool muted_ = true, asked_ = false, light_on_sent_ = false;
  std::string line_;
  TimePoint line_began_{}, obeyed_{}, replied_{};
  TimePoint answered_{};  // end of the last complete reply; an echo does not count
  TimePoint off_sent_{};
  std::unique_ptr<Timer> power_timer_;
  std::uint64_t next_timer_ = 0;
  std::map<std::uint64_t, std::unique_ptr<Timer>> timers_;
};

// The computer's end of the line: one adapter, until it is unplugged.
class LineEnd final : public ByteChannel {
 public:
  // The model must outlive the end. `before_write` is called before bytes go out.
  LineEnd(ProjectorModel& model, std::function<void()> before_write)
      : model_(model), before_write_(std::move(before_write)) {}

  [[nodiscard]] const std::string& name() const override { return name_; }
  void listen(Listener listener) override { listener_ = std::move(listener); }
  [[nodiscard]] bool write(std::string_view bytes) noexcept override {
    if (plugged_) before_write_();
    if (!plugged_) return false;
    model_.receive(std::string(bytes));
    return true;
  }
  void write_and_wait(std::string_view bytes, Duration) noexcept override {
    if (plugged_ && !bytes.empty()) model_.receive(std::string(bytes));
  }
  [[nodiscard]] int descriptor() const noexcept override { return -1; }

  // Delivers bytes; called by the loop.
  void bring(const std::string& bytes) {
    if (plugged_ && listener_.bytes) listener_.bytes(bytes);
  }
  void tell_loss() {
    if (listener_.lost) listener_.lost("the serial port was lost: it was unplugged");
  }
  void unplug() { plugged_ = false; }
  [[nodiscard]] bool plugged() const { return plugged_; }

 private:
  ProjectorModel& model_;
  std::function<void()> before_write_;
  std::string name_ = "/dev/ttyUSB7";
  Listener listener_;
  bool plugged_ = true;
};

}  // namespace contourd::rig
