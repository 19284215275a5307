// The truth about a print besides the daemon's records: each layer's light, the screen, the plate. Checks
// both against the rules and keeps the violations. Not thread-safe.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/print/print_mode.hpp"

namespace contourd::rig {

// Totals over the prints of one world or of many.
struct Figures {
  std::uint64_t prints = 0, done = 0, canceled = 0, failed = 0;
  std::uint64_t layers = 0, parts = 0, slices = 0, interruptions = 0, line_faults = 0, happenings = 0;
  std::uint64_t unconfirmed = 0;  // records without confirmed darkness
  Duration widest{};              // widest bounds of a record
  Duration most_over{};           // true light beyond the requested time, all of it recorded
  Duration longest_pause{};       // without a light off or power off while light off was due
  void add(const Figures& other);
};

struct Violation {
  std::string rule;  // letter and name of the rule: "b: bounds contain the light"
  std::string what;
  TimePoint at{};
};

class Verdict {
 public:
  // Allows the plate to be `step` away from its reported place.
  explicit Verdict(Nanometers step) : step_(step) {}

  struct Scene {
    TimePoint now{};
    bool lit = false;             // true light
    bool stray = false;           // true light that was never requested
    std::optional<int> picture;   // number of the mask on the screen; nullopt: black
    std::int64_t lit_pixels = 0;  // of this picture
    bool screen_is_in_use = true;
    Nanometers plate{};  // true height above the film
    std::string_view state;
    bool may_be_lit = false;             // the process means the light to be on, or has just turned it on
    bool rises = false;                  // the plate is to rise in the light
    bool loop_runs = true;               // has not been held up recently
    std::uint64_t flips = 0;             // of the screen's picture
    bool light_off_unconfirmed = false;  // the machine reports that the light may be on
    bool light_off_due = false;          // the projector may be lit, and commands reach it
    TimePoint off_sent{};                // the last light off or power off
    Duration longest_pause{};            // between two of these while light off is due
  };
  // Checks the rules; call it after every event.
  void look(const Scene& scene);

  // Records that the daemon means to expose this layer at this height from now on.
  void light_asked(int layer, Nanometers height, Duration part);
  void light_unasked() { wanted_ = false; }
  void recorded(int layer, const LayerRecord& record, TimePoint now);
  // Adds the record of a slice to that of its rise, which has this number.
  void slice_recorded(int rise, const LayerRecord& record);
  // Checks the records after everything has ended.
  void close(TimePoint now);
  void break_rule(const std::string& rule, const std::string& what, TimePoint now);

  [[nodiscard]] const std::vector<Violation>& violations() const { return violations_; }
  // Longest light of a layer beyond the requested time if nothing went wrong; nullopt: unlimited.
  std::optional<Duration> slack;
  // Most light that each part of a complete layer may lack; nullopt: unlimited.
  std::optional<Duration> shortfall;
  // The display's refresh if exposures are split: of kPixels, half are to get kShare of the light, in 255ths.
  std::optional<Duration> frame;
  // Latest that a picture may be; nullopt: unlimited.
  std::optional<Duration> latest_picture;
  // The longest way of the plate in the light of a rise under one mask.
  Nanometers oldest_mask{};
  static constexpr std::int64_t kPixels = 100;
  static constexpr std::uint8_t kShare = 64;
  Figures figures;

 private:
  struct Layer {
    Duration light{};  // true light, without light that is still on
    Duration asked{};
    Duration masked{}, whole{};  // light through a mask, and through one with all kPixels
    std::optional<LayerRecord> record;
  };
  [[nodiscard]] Duration light_of(int layer, TimePoint now) const;
  void light_begins(const Scene& scene);
  void check_light(const Scene& scene);
  void check_split(const LayerRecord& record, const Layer& layer, TimePoint now);
  void check_light_off(const Scene& scene);

  Nanometers step_;
  std::map<int, Layer> layers_;
  std::optional<int> layer_;  // layer for which light was last requested
  Nanometers height_{};       // height for which it was requested
  bool wanted_ = false;       // the request has not been withdrawn
  bool lit_ = false, stray_ = false;
  TimePoint lit_since_{}, looked_at_{};
  std::int64_t lit_pixels_ = 0;  // on the screen since looked_at_
  std::optional<TimePoint> light_off_due_since_;
  std::uint64_t flips_ = 0;
  Nanometers mask_at_{};  // plate's height when the mask on the screen appeared
  Nanometers lit_at_{},
      highest_{};  // plate heights under this light: at its beginning, and the highest since
  std::vector<Violation> violations_;
};

}  // namespace contourd::rig
