// Fuzz target: a projector that sends any bytes at any moment while a user switches it (see Play). The first
// byte chooses its table. The light is never taken for dark without a reply that says so, to a command sent
// after the last one that may have lit it. Every message is one printable line.
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/config/projector_table.hpp"
#include "hw/serial/serial_projector.hpp"
#include "hw/virtual_clock.hpp"
#include "tests/fuzz/told.hpp"
#include "tests/hw/serial/projector_tables.hpp"

namespace contourd::fuzz {
namespace {

// Everything that the projector sent, and from where on it may have reported darkness. Does not know which
// reply belongs to which command.
class Evidence {
 public:
  explicit Evidence(const ProjectorTable& table) : table_(table) {}

  void sent(std::string_view bytes) {
    if (bytes == table_.power_on.bytes || is(table_.light_on, bytes)) {
      lit_ = true;
      asked_.clear();
    }
    if (bytes == table_.power_off.bytes) ask(table_.power_off);
    for (const auto* command : {&table_.light_off, &table_.light, &table_.power})
      if (is(*command, bytes)) ask(**command);
  }
  void heard(std::string_view bytes) {
    starts_.push_back(heard_.size());
    heard_ += bytes;
    if (lit_ && says_dark()) lit_ = false;
  }
  [[nodiscard]] bool lit() const { return lit_; }
  // Sets the state before the first command, which is unknown.
  void suppose_lit(bool lit) { lit_ = lit; }

 private:
  // A command that was sent, and the number of bytes heard before it.
  struct Asked {
    const ProjectorCommand* command;
    std::size_t since;
  };

  [[nodiscard]] static bool is(const std::optional<ProjectorCommand>& command, std::string_view bytes) {
    return command && command->bytes == bytes;
  }
  void ask(const ProjectorCommand& command) {
    const auto is_it = [&](const Asked& each) { return each.command == &command; };
    if (std::ranges::none_of(asked_, is_it)) asked_.push_back({&command, heard_.size()});
  }

  [[nodiscard]] bool says_dark() const {
    for (const auto& [command, since] : asked_) {
      for (const auto& [meaning, pattern] : command->replies)
        if ((meaning == ReplyMeaning::Off || meaning == ReplyMeaning::Accepted) && came_now(pattern, since))
          return true;
    }
    return std::ranges::any_of(table_.unasked, [this](const UnaskedLine& line) {
      return line.kind == UnaskedLine::Kind::Off && came_now(line.pattern, 0);
    });
  }

  // True if any part of the received bytes that begins at `since` or later and ends in the last portion fits
  // the pattern. A line may begin and end where the projector paused.
  [[nodiscard]] bool came_now(const ReplyPattern& pattern, std::size_t since) const {
    const std::string_view all = heard_;
    for (std::size_t end = std::max(starts_.back(), since); end <= all.size(); ++end) {
      if (pattern.is_of_bytes() ? pattern.match_end(all.substr(since, end - since)).has_value()
                                : is_end(end) && is_line_to(end, pattern, since))
        return true;
    }
    return false;
  }
  [[nodiscard]] bool is_end(std::size_t at) const {
    return at == heard_.size() || heard_[at] == '\r' || heard_[at] == '\n';
  }
  // Returns the text without the control characters and blanks around it.
  [[nodiscard]] std::string_view trimmed(std::size_t begin, std::size_t end) const {
    const auto is_blank = [this](std::size_t at) {
      return static_cast<unsigned char>(heard_[at]) <= ' ' || heard_[at] == '\x7F';
    };
    while (begin < end && is_blank(begin))
      ++begin;
    while (begin < end && is_blank(end - 1))
      --end;
    return std::string_view(heard_).substr(begin, end - begin);
  }
  [[nodiscard]] bool is_line_to(std::size_t end, const ReplyPattern& pattern, std::size_t since) const {
    const auto fits = [&](std::size_t begin) {
      if (begin >= end) return false;
      const std::string_view line = trimmed(begin, end);
      return line.data() >= heard_.data() + since && pattern.match_line(line).has_value();
    };
    if (std::ranges::any_of(starts_, fits)) return true;
    for (std::size_t begin = 1; begin < end; ++begin)
      if (is_end(begin - 1) && fits(begin)) return true;
    return false;
  }

  const ProjectorTable& table_;
  bool lit_ = false;
  std::string heard_;
  std::vector<std::size_t> starts_;  // start of each portion
  std::vector<Asked> asked_;         // commands sent since the light may have been lit
};

// A serial line without a projector: records the sent bytes and passes on the bytes it is given.
class FuzzedChannel final : public ByteChannel {
 public:
  explicit FuzzedChannel(Evidence& evidence) : evidence_(evidence) {}

  void hear(std::string_view bytes) {
    evidence_.heard(bytes);
    if (listener_.bytes) listener_.bytes(bytes);
  }
  void unplug() {
    if (!std::exchange(plugged_, false)) return;
    if (listener_.lost) listener_.lost("the serial port /dev/ttyUSB7 was lost: it was unplugged");
  }

  // Returns the number of messages written.
  [[nodiscard]] int messages() const { return messages_; }

  [[nodiscard]] const std::string& name() const override { return name_; }
  void listen(Listener listener) override { listener_ = std::move(listener); }
  [[nodiscard]] bool write(std::string_view bytes) noexcept override {
    ++messages_;
    if (plugged_) evidence_.sent(bytes);
    return plugged_;
  }
  void write_and_wait(std::string_view, Duration) noexcept override {}
  [[nodiscard]] int descriptor() const noexcept override { return -1; }

 private:
  Evidence& evidence_;
  std::string name_ = "/dev/ttyUSB7";
  Listener listener_;
  bool plugged_ = true;
  int messages_ = 0;
};

// Plays a sequence of moves. Each byte is a user action (see move()) or time that passes (t, T). After an r
// comes the number of bytes that the projector sends, then those bytes; an R first waits until a message was
// sent that has had no reply.
class Play {
 public:
  explicit Play(const ProjectorTable& table)
      : table_(table), evidence_(table), channel_(evidence_), projector_(channel_, clock_, table) {
    projector_.on_event([](const MachineEvent& event) { demand_sentence(event.what); });
  }

  void play(std::string_view moves) {
    for (std::size_t i = 0; i < moves.size(); ++i) {
      if ((moves[i] == 'r' || moves[i] == 'R') && i + 1 < moves.size()) {
        if (moves[i] == 'R') pass_until_sent();
        const std::string_view bytes = moves.substr(i + 2, static_cast<std::uint8_t>(moves[i + 1]));
        i += 1 + bytes.size();
        answered_ = channel_.messages();
        channel_.hear(bytes);
      } else {
        move(moves[i]);
      }
      demand_sound();
    }
    pass(50);
  }

 private:
  void move(char what) {
    switch (what) {
      case 't':
        return pass(1);
      case 'T':
        return pass(10);
      case 'u':
        return channel_.unplug();
      case 'd':
        // The light that another program may have left on is not covered here.
        return projector_.when_dark([this] {
          if (!confirming_) demand_dark("darkness is reported while lit");
        });
      case 's':
        return projector_.ask_status([](const ProjectorStatus& status) {
          if (status.reply != ProjectorReply::Ok) demand_sentence(status.problem);
        });
      case 'm':
      case 'c':
        return at_first(what == 'c');
      default:
        switch_it(what);
    }
  }

  void pass_until_sent() {
    for (int i = 0; i < 20 && channel_.messages() == answered_ && clock_.run_next(); ++i)
      demand_sound();
  }
  void pass(int calls) {
    for (int i = 0; i < calls && clock_.run_next(); ++i)
      demand_sound();
  }

  // Actions on a projector that another program may have left on: only before any other command.
  void at_first(bool whether_dark) {
    if (begun_) return;
    if (!whether_dark) return projector_.may_warm_up();
    if (!table_.light_off) return;
    begun_ = confirming_ = true;
    evidence_.suppose_lit(true);
    projector_.confirm_dark([this](ProjectorReply reply) {
      if (!confirming_) return;
      if (reply == ProjectorReply::Ok) demand_dark("darkness is confirmed while lit");
      stop_confirming();
    });
  }
  void stop_confirming() {
    if (std::exchange(confirming_, false)) evidence_.suppose_lit(false);
  }

  void switch_it(char what) {
    if (std::string_view("pofx").find(what) == std::string_view::npos) return;
    begun_ = true;
    stop_confirming();
    if (what == 'o') return light_on();
    wanted_ = false;
    if (what == 'f') return projector_.light_off();
    powered_ = false;
    if (what == 'x') return projector_.power_off();
    projector_.power_on([this](ProjectorReply reply) {
      powered_ = reply == ProjectorReply::Ok;
      if (powered_) demand_dark("power on reports darkness while lit");
    });
  }

  void light_on() {
    if (!table_.switches_light() || !powered_ || wanted_ || !projector_.light_off_unconfirmed().empty())
      return;
    wanted_ = true;
    projector_.light_on(std::chrono::seconds{2},
                        {.sent = [](TimePoint) {},
                         .done = [this](ProjectorReply reply) { wanted_ = reply == ProjectorReply::Ok; }});
  }

  void demand_dark(const char* what) const { demand(!table_.switches_light() || !evidence_.lit(), what); }

  void demand_sound() const {
    const std::string unconfirmed = projector_.light_off_unconfirmed(), problem = projector_.last_problem();
    if (!problem.empty()) demand_sentence(problem);
    for (const std::string& why : projector_.why_not_ready())
      demand_sentence(why);
    if (!unconfirmed.empty()) return demand_sentence(unconfirmed);
    if (!wanted_ && !confirming_) demand_dark("the light is taken for dark without a reply that says so");
  }

  const ProjectorTable& table_;
  VirtualClock clock_;
  Evidence evidence_;
  FuzzedChannel channel_;
  SerialProjector projector_;
  int answered_ = 0;  // messages that had a reply
  bool begun_ = false, powered_ = false, wanted_ = false, confirming_ = false;
};

// The first two tables have all possible commands.
std::vector<ProjectorTable> read_tables() {
  std::vector<ProjectorTable> tables{testing::text_table(), testing::bytes_table()};
  tables[0].light =
      testing::text_command("light", "~0355 1", {{ReplyMeaning::On, "OK0"}, {ReplyMeaning::Off, "OK1"}});
  for (const std::string name :
       {"optoma", "anhua-df10", "benq", "vivitek-d535", "acer", "viewsonic-pjd7820hd"})
    tables.push_back(
        load_projector_table(std::filesystem::path(CONTOURD_CONFIG_DIR) / "projectors" / (name + ".json")));
  return tables;
}

}  // namespace
}  // namespace contourd::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace contourd::fuzz;
  static const std::vector<contourd::ProjectorTable> tables = read_tables();
  if (size == 0 || size > 600) return 0;
  Play(tables[data[0] % tables.size()]).play({reinterpret_cast<const char*>(data) + 1, size - 1});
  return 0;
}
