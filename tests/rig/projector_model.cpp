#include "tests/rig/projector_model.hpp"

#include <algorithm>
#include <utility>

#include "hw/serial/reply_pattern.hpp"
#include "tests/hw/serial/projector_tables.hpp"

namespace contourd::rig {
namespace {

using namespace std::chrono_literals;
using contourd::testing::text_command;

constexpr Duration kCooling = 3s;
// Latest time of a reply after its command, or after the reply before it. A later reply belongs to no command
// any more (ReplyReader).
constexpr Duration kLatest = 1'900ms, kLatestOfLightOn = 20s;

void garble(std::string& bytes, Dice& dice) {
  const auto at = static_cast<std::size_t>(dice.below(bytes.size()));
  // A '#' occurs in no reply and no command.
  if (dice.chance(0.3)) {
    bytes.erase(at, 1);
  } else {
    bytes[at] = '#';
  }
}

}  // namespace

ProjectorTable table_of(const ProjectorTraits& traits, bool switches_light) {
  using M = ReplyMeaning;
  ProjectorTable table = contourd::testing::text_table(switches_light);
  table.echo = traits.echoes;
  table.gap = traits.gap;
  table.latency = traits.latency;
  table.warm_up = 5s;
  table.cool_down = kCooling;
  if (switches_light && traits.answers_light)
    table.light = text_command("light", "~00355 1", {{M::On, "BL0"}, {M::Off, "BL1"}});
  return table;
}

ProjectorModel::ProjectorModel(VirtualClock& world, const ProjectorTraits& traits, bool switches_light,
                               const LineFaults& faults, std::uint64_t seed)
    : world_(world),
      traits_(traits),
      table_(table_of(traits, switches_light)),
      faults_(faults),
      dice_(seed, 1) {
  if (!traits.left_on) return;
  power_ = Power::On;
  muted_ = false;
}

Duration ProjectorModel::wire_time(std::size_t bytes) const {
  return std::chrono::nanoseconds{std::int64_t{10'000'000'000} * static_cast<std::int64_t>(bytes) /
                                  table_.baud};
}

void ProjectorModel::at(TimePoint when, std::function<void()> call) {
  const std::uint64_t id = next_timer_++;
  timers_[id] = world_.call_at(when, [this, id, call = std::move(call)] {
    call();
    timers_.erase(id);
  });
}

void ProjectorModel::receive(const std::string& bytes) {
  std::string arrived = bytes;
  tell("sent " + readable_bytes(bytes));
  if (table_.light_on && table_.light_on->bytes == bytes) light_on_sent_ = true;
  if ((table_.light_off && table_.light_off->bytes == bytes) || table_.power_off.bytes == bytes)
    off_sent_ = world_.now();
  if (happens(faults_.command_lost)) return tell("and lost");
  if (happens(faults_.command_garbled)) garble(arrived, dice_);
  const TimePoint first_byte = world_.now();
  at(first_byte + wire_time(bytes.size()), [this, arrived, first_byte] {
    if (line_.empty()) line_began_ = first_byte;
    line_ += arrived;
    if (!line_.ends_with('\r')) return;
    take_line(std::exchange(line_, {}), line_began_);
  });
}

ProjectorModel::Command ProjectorModel::command_in(const std::string& line) const {
  const auto is = [&line](const std::optional<ProjectorCommand>& command) {
    return command && command->bytes == line;
  };
  if (is(table_.power_on)) return Command::PowerOn;
  if (is(table_.power_off)) return Command::PowerOff;
  if (is(table_.light_on)) return Command::LightOn;
  if (is(table_.light_off)) return Command::LightOff;
  if (is(table_.power)) return Command::AskPower;
  if (is(table_.light)) return Command::AskLight;
  return Command::Unknown;
}

// Takes a command; commands are obeyed one after the other, in their order.
void ProjectorModel::take_line(const std::string& line, TimePoint first_byte) {
  const Command command = command_in(line);
  TimePoint when = world_.now();
  if (command == Command::LightOn) {
    when = std::max(when, first_byte + traits_.latency) + dice_.between(Duration{0}, traits_.slower);
  } else if (command == Command::LightOff) {
    when += dice_.between(Duration{0}, traits_.darkening);
  }
  obeyed_ = std::max(when, obeyed_);
  if (traits_.echoes) reply(line, world_.now(), world_.now() + kLatest);
  at(obeyed_, [this, command, came = world_.now()] { obey(command, came); });
}

void ProjectorModel::obey(Command command, TimePoint came) {
  const auto answer = [&](const std::string& text) {
    const TimePoint earliest = std::max(world_.now(), replied_);
    const Duration latest = command == Command::LightOn ? kLatestOfLightOn : kLatest;
    Duration thinks = dice_.between(Duration{1'000'000}, traits_.thinks);
    if (command == Command::LightOn) thinks += dice_.between(Duration{0}, traits_.lights_late);
    const bool whole = reply(text + "\r", earliest + thinks, std::max(came + latest, answered_ + kLatest));
    if (whole) answered_ = replied_;
  };
  const bool is_on = power_ == Power::On, warming = power_ == Power::Warming;
  using While = ProjectorTraits::WhileWarm;
  switch (command) {
    case Command::PowerOn:
      if (power_ == Power::Off) {
        power_ = Power::Warming;
        muted_ = !traits_.comes_up_lit;
        asked_ = false;
        power_timer_ = world_.call_after(traits_.warms_up, [this] { warm(); });
      }
      return answer("P");
    case Command::PowerOff:
      if (warming && traits_.off_while_warming == While::Silent) return;
      if (warming && traits_.off_while_warming == While::Refuses) return answer("F");
      if (is_on || warming) {
        power_ = Power::Cooling;
        changed();
        power_timer_ = world_.call_after(kCooling, [this] { power_ = Power::Off; });
      }
      return answer("P");
    case Command::LightOn:
    case Command::LightOff: {
      const bool obeys = is_on || (warming && traits_.off_while_warming == While::Obeys);
      if (!obeys && traits_.off_while_warming == While::Silent) return;
      if (!obeys) return answer("F");
      muted_ = command == Command::LightOff;
      asked_ = command == Command::LightOn;
      changed();
      return answer("P");
    }
    case Command::AskPower:
      return answer(is_on || (warming && traits_.warming_is_on) ? "OK1" : "OK0");
    case Command::AskLight:
      return is_on ? answer(muted_ ? "BL1" : "BL0") : answer("F");
    case Command::Unknown:
      // Noise is sometimes answered.
      if (dice_.chance(0.5)) answer("F");
      return;
  }
}

void ProjectorModel::warm() {
  power_ = Power::On;
  if (!table_.switches_light()) muted_ = false;
  changed();
}

// Sends a reply and returns true if it arrives complete.
bool ProjectorModel::reply(const std::string& text, TimePoint sent_at, TimePoint latest) {
  if (happens(faults_.reply_late)) sent_at += dice_.spread(10ms, kLatestOfLightOn);
  replied_ = std::max(std::min(sent_at, latest), replied_);
  std::string bytes = text;
  if (happens(faults_.reply_lost)) {
    tell("lost " + readable_bytes(bytes));
    return false;
  }
  const bool garbled = happens(faults_.reply_garbled);
  if (garbled) garble(bytes, dice_);
  if (happens(faults_.reply_doubled)) bytes += bytes;
  send(bytes, replied_ + wire_time(bytes.size()));
  return !garbled;
}

void ProjectorModel::send(std::string bytes, TimePoint when) {
  at(when, [this, bytes = std::move(bytes)] {
    tell("heard " + readable_bytes(bytes));
    answers(bytes);
  });
}

}  // namespace contourd::rig
