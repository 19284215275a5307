// One print, or two, with all that will go wrong: drawn from a seed, told in a line, made smaller when it has
// shown something. Value types.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/units.hpp"
#include "hw/clock.hpp"
#include "tests/rig/projector_model.hpp"

namespace contourd::rig {

enum class LightKind {
  Serial,          // switched by commands
  SerialAndLine,   // the same, and a line before it
  PoweredAndLine,  // the projector can be powered only; a line before it
  Line,            // nothing but a line
};

struct Happening {
  enum class Kind {
    Pause,
    Resume,
    Cancel,
    Fail,
    OpenLid,
    PressStop,
    ChatteringLid,
    ChatteringStop,
    LoopHeldUp,
    LoopHeldUpInWrite,  // within the next call that sends something
    StepsHeldUp,
    InputsHeldUp,
    AdapterUnplugged,
    FlipEventLost,  // of the next picture: nobody is told of it
    FlipLost,       // the next picture does not come up, and that is told after a while
    DisplayLost,
    LineRefuses,   // to change
    EncoderLoses,  // some of its counts
    EncoderLosesUpwards,
  };
  Kind kind;
  int state = 0;      // once the print has entered so many states
  Duration after{};   // and so long after that
  Duration length{};  // where it lasts
  int times = 1;      // of an input that chatters
};

enum class EncoderKind { None, Faults, Corrects };

struct Scenario {
  std::uint64_t seed = 0;
  LightKind light = LightKind::Serial;
  ProjectorTraits projector;
  LineFaults line;
  EncoderKind encoder = EncoderKind::None;
  bool backlash = false;
  bool interrupts_beyond_tolerance = false;  // the resin's exposure_doubt
  int prints = 1;
  int layers = 2;
  Duration exposure{};
  Duration settle{}, rest{};
  std::vector<Happening> happenings;

  // Nothing on the line, and nothing that holds anything up: the light is to be as asked.
  [[nodiscard]] bool undisturbed() const;
  [[nodiscard]] bool has(std::initializer_list<Happening::Kind> any) const;
  // How far the plate may be from where it is said to be, a motor's step included.
  [[nodiscard]] Nanometers plate_tolerance(Nanometers step) const;
  // How long after a safety input's first edge the light goes off; nothing: it depends on what else goes
  // wrong.
  [[nodiscard]] std::optional<Duration> darkening_after_edge() const;
};

[[nodiscard]] Scenario draw_scenario(std::uint64_t seed);
[[nodiscard]] std::string describe(const Happening& happening);
[[nodiscard]] std::string describe(const Scenario& scenario);

}  // namespace contourd::rig
