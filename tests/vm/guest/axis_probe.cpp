// A GpioAxis on the virtual machine's modelled Z axis, told what to do by its arguments, each with what came
// of it and the height on a line of standard output:
//
//   axis-probe [setting=value]... [lines] [home] [move MM MM_PER_S] [stop-after MS] [abort-after MS] [wait
//   MS] [report]
//
// Settings: chip, step, direction, enable, limit, second, estop, lid, encoder_a, encoder_b (line numbers or
// names), steps_per_mm, homing_speed, top_speed, acceleration, jerk, backlash_um, switch_um, travel_mm,
// counts_per_mm, policy (fault, correct), priority, debounce_us.
#include <poll.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "hw/gpio/gpio_axis.hpp"
#include "hw/gpio/gpio_lines.hpp"

using namespace contourd;

namespace {

// The event loop: poll() over the watched descriptors and the timers.
class Loop final : public Clock, public DescriptorWatcher {
 public:
  [[nodiscard]] TimePoint now() const override { return monotonic_now(); }
  [[nodiscard]] std::unique_ptr<Timer> call_at(TimePoint when, std::function<void()> call) override {
    const Key key{when, next_++};
    calls_.emplace(key, std::move(call));
    return std::make_unique<Pending>(*this, key);
  }
  [[nodiscard]] std::unique_ptr<Watch> when_readable(int fd, std::function<void()> call) override {
    watched_[fd] = std::move(call);
    return std::make_unique<Watched>(*this, fd);
  }
  void run(const std::function<bool()>& done) {
    while (!done())
      turn();
  }

 private:
  using Key = std::pair<TimePoint, int>;
  struct Pending final : Timer {
    Pending(Loop& l, Key k) : loop(l), key(k) {}
    ~Pending() override { loop.calls_.erase(key); }
    Loop& loop;
    Key key;
  };
  struct Watched final : Watch {
    Watched(Loop& l, int f) : loop(l), fd(f) {}
    ~Watched() override { loop.watched_.erase(fd); }
    Loop& loop;
    int fd;
  };

  void turn() {
    std::vector<pollfd> fds;
    for (const auto& [fd, call] : watched_)
      fds.push_back({fd, POLLIN, 0});
    const Duration left =
        calls_.empty() ? Duration{0} : std::max(calls_.begin()->first.first - now(), Duration{0});
    const timespec time{left / std::chrono::seconds{1}, (left % std::chrono::seconds{1}).count()};
    ppoll(fds.data(), fds.size(), calls_.empty() ? nullptr : &time, nullptr);
    for (const pollfd& fd : fds) {
      if (fd.revents == 0 || watched_.count(fd.fd) == 0) continue;
      const auto call = watched_[fd.fd];
      call();
    }
    while (!calls_.empty() && calls_.begin()->first.first <= now())
      calls_.extract(calls_.begin()).mapped()();
  }

  std::map<Key, std::function<void()>> calls_;
  std::map<int, std::function<void()>> watched_;
  int next_ = 0;
};

class Settings {
 public:
  std::map<std::string, std::string> values;
  [[nodiscard]] bool has(const char* key) const { return values.count(key) != 0; }
  [[nodiscard]] double number(const char* key, double otherwise) const {
    return has(key) ? std::atof(values.at(key).c_str()) : otherwise;
  }
  [[nodiscard]] GpioLineConfig line(const char* key, const char* otherwise, bool active_low) const {
    return {has("chip") ? values.at("chip") : "zplant", has(key) ? values.at(key) : otherwise, active_low};
  }
  [[nodiscard]] GpioInputConfig input(const char* key, const char* otherwise, bool active_low) const {
    return {line(key, otherwise, active_low), LineBias::AsIs,
            Duration{static_cast<Duration::rep>(number("debounce_us", 5000) * 1e3)}};
  }
};

GpioAxisConfig config_of(const Settings& s) {
  const auto nm = [](double um) { return Nanometers{static_cast<std::int64_t>(um * 1e3)}; };
  GpioAxisConfig c;
  c.step = s.line("step", "17", false);
  c.direction = s.line("direction", "27", false);
  c.enable = s.line("enable", "22", true);
  c.limit_switch = s.input("limit", "23", true);
  if (s.has("second")) c.second_switch = s.input("second", "", false);
  if (s.has("estop")) c.emergency_stop = s.input("estop", "", false);
  if (s.has("lid")) c.lid = s.input("lid", "", false);
  if (s.has("encoder_a")) {
    c.encoder.emplace();
    c.encoder->a = s.line("encoder_a", "", false);
    c.encoder->b = s.line("encoder_b", "", false);
    c.encoder->counts_per_mm = s.number("counts_per_mm", 800);
    if (s.has("policy") && s.values.at("policy") == "correct")
      c.encoder->policy = EncoderConfig::Policy::Correct;
  }
  c.microsteps_per_mm = s.number("steps_per_mm", 800);
  c.homing_speed = MillimetersPerSecond{s.number("homing_speed", 5)};
  c.top_speed = MillimetersPerSecond{s.number("top_speed", 15)};
  c.acceleration = MillimetersPerSecondSquared{s.number("acceleration", 25)};
  if (s.has("jerk")) c.jerk_mm_s3 = s.number("jerk", 0);
  c.backlash = nm(s.number("backlash_um", 0));
  c.switch_height = nm(s.number("switch_um", 0));
  c.travel = nm(s.number("travel_mm", 100) * 1e3);
  c.realtime_priority = static_cast<int>(s.number("priority", 50));
  return c;
}

class Probe {
 public:
  Probe(Loop& loop, const GpioAxisConfig& config) : loop_(loop), axis_(loop, loop, config) {
    axis_.on_disturbance([](const Disturbance& d) {
      std::printf("%s %s\n", d.kind == Disturbance::Kind::Fault ? "fault:" : "interruption:", d.what.c_str());
    });
    for (const std::string& refusal : axis_.refusals())
      std::printf("refused: %s\n", refusal.c_str());
  }

  void home() {
    axis_.home([this](HomingResult result) { answer("home", describe(result)); });
    loop_.run([this] { return !axis_.moving(); });
  }
  void move(double mm, double speed) {
    axis_.move_to(Nanometers{static_cast<std::int64_t>(mm * 1e6)}, MillimetersPerSecond{speed},
                  [this](MoveResult result) { answer("move", describe(result)); });
    loop_.run([this] { return !axis_.moving(); });
  }
  // During the next movement.
  void later(double ms, bool abort) {
    timer_ = loop_.call_after(milliseconds(ms), [this, abort] {
      if (!abort) return axis_.stop();
      axis_.abort();
      answer("aborted", "");
    });
  }
  void wait(double ms) {
    bool over = false;
    timer_ = loop_.call_after(milliseconds(ms), [&over] { over = true; });
    loop_.run([&over] { return over; });
  }
  void report() {
    const LateSteps late = axis_.late_steps();
    std::printf("late steps %llu, worst %lld us; illegal encoder edges %llu\n",
                static_cast<unsigned long long>(late.count),
                static_cast<long long>(late.worst.count() / 1000),
                static_cast<unsigned long long>(axis_.illegal_encoder_edges()));
  }

 private:
  static Duration milliseconds(double ms) { return Duration{static_cast<Duration::rep>(ms * 1e6)}; }
  void answer(const char* what, std::string_view result) {
    const auto height = axis_.height();
    std::printf("%s: %s; height %s\n", what, std::string(result).c_str(),
                height ? (std::to_string(height->count()) + " nm").c_str() : "unknown");
  }

  Loop& loop_;
  GpioAxis axis_;
  std::unique_ptr<Timer> timer_;
};

void report_lines(const GpioAxisConfig& config) {
  for (const GpioLineConfig* line : {&config.step, &config.direction, &config.limit_switch.line})
    std::printf("%s\n", describe(report_line(*line)).c_str());
}

void run(const std::vector<std::string>& words, const GpioAxisConfig& config) {
  if (words.size() == 1 && words[0] == "lines") return report_lines(config);
  Loop loop;
  Probe probe(loop, config);
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    const auto number = [&] { return std::atof(words.at(++i).c_str()); };
    if (word == "home") probe.home();
    if (word == "report") probe.report();
    if (word == "lines") report_lines(config);
    if (word == "stop-after") probe.later(number(), false);
    if (word == "abort-after") probe.later(number(), true);
    if (word == "wait") probe.wait(number());
    if (word == "move") {
      const double mm = number();
      probe.move(mm, number());
    }
  }
}

}  // namespace

int main(int argc, char** argv) try {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  Settings settings;
  std::vector<std::string> words;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (const auto equals = word.find('='); equals != std::string::npos) {
      settings.values[word.substr(0, equals)] = word.substr(equals + 1);
    } else {
      words.push_back(word);
    }
  }
  run(words, config_of(settings));
} catch (const std::exception& error) {
  std::printf("error: %s\n", error.what());
  return 1;
}
