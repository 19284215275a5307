// What is true of a print, beside what the daemon believes of it: each layer's light, the screen, the plate.
// Holds both against the rules and keeps what broke one. Not thread-safe.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/print/print_process.hpp"

namespace contourd::rig {

// Of all prints of a world, or of many.
struct Figures {
  std::uint64_t prints = 0, done = 0, canceled = 0, failed = 0;
  std::uint64_t layers = 0, parts = 0, interruptions = 0, line_faults = 0, happenings = 0;
  std::uint64_t unconfirmed = 0;  // records whose darkness nobody confirmed
  Duration widest{};              // of a record's bounds
  Duration most_over{};           // true light beyond what was asked, all of it recorded
  void add(const Figures& other);
};

struct Violation {
  std::string rule;  // its letter and what it is: "b: bounds"
  std::string what;
  TimePoint at{};
};

class Verdict {
 public:
  // `step`: how far the plate may be from where it is said to be.
  explicit Verdict(Nanometers step) : step_(step) {}

  struct Scene {
    TimePoint now{};
    bool lit = false;            // true light
    bool stray = false;          // which nobody has asked for
    std::optional<int> picture;  // on the screen
    bool screen_is_in_use = true;
    Nanometers plate{};  // truly, above the film
    PrintState state = PrintState::Idle;
    bool light_off_unconfirmed = false;  // the machine says that the light may be on
  };
  // After everything that happened.
  void look(const Scene& scene);

  // The daemon means to expose, from now on, this layer at this height.
  void light_asked(int layer, Nanometers height, Duration part);
  void light_unasked() { wanted_ = false; }
  void recorded(int layer, const LayerRecord& record, TimePoint now);
  // All is over and was given time.
  void close(TimePoint now);
  void break_rule(const std::string& rule, const std::string& what, TimePoint now);

  [[nodiscard]] const std::vector<Violation>& violations() const { return violations_; }
  // Light of a layer may be longer than asked by this, where nothing went wrong; nothing: by any time.
  std::optional<Duration> slack;
  // How much less each part of a whole layer may have had; nothing: that depends on what goes wrong.
  std::optional<Duration> shortfall;
  Figures figures;

 private:
  struct Layer {
    Duration light{};  // true; what is on is not in it yet
    Duration asked{};
    std::optional<LayerRecord> record;
  };
  [[nodiscard]] Duration light_of(int layer, TimePoint now) const;
  void light_begins(const Scene& scene);
  void check_light(const Scene& scene);

  Nanometers step_;
  std::map<int, Layer> layers_;
  std::optional<int> layer_;  // that the last light was asked for
  Nanometers height_{};       // and at which
  bool wanted_ = false;       // and nobody has taken that back
  bool lit_ = false, stray_ = false;
  TimePoint lit_since_{};
  Nanometers lit_at_{}, highest_{};  // of the plate, under this light: at first, and since
  std::vector<Violation> violations_;
};

}  // namespace contourd::rig
