// Scenarios: one print, or two, with all failures that will happen. A scenario is drawn from a seed,
// described in a few lines, and reduced if it breaks a rule. Value types.
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
  Serial,          // light switched by commands
  SerialAndLine,   // light switched by commands, behind a light line
  PoweredAndLine,  // the projector can only be powered, behind a light line
  Line,            // a light line alone
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
    LoopHeldUpInWrite,  // within the next call that sends bytes
    StepsHeldUp,
    InputsHeldUp,
    AdapterUnplugged,
    FlipEventLost,  // the next picture comes up, but its event is lost
    FlipLost,       // the next picture does not come up, which is reported after a while
    DisplayLost,
    LineRefuses,   // the light line cannot be changed
    EncoderLoses,  // some counts are lost
    EncoderLosesUpwards,
    RiseChanges,  // the user changes the speed of the rise
    PressForce,   // the force on the plate exceeds its threshold
  };
  Kind kind;
  int state = 0;      // the number of states that the print has entered before
  Duration after{};   // delay after that
  Duration length{};  // duration of a happening that lasts
  int times = 1;      // cycles of a chattering input
};

enum class EncoderKind { None, Faults, Corrects };

struct Scenario {
  std::uint64_t seed = 0;
  LightKind light = LightKind::Serial;
  ProjectorTraits projector;
  LineFaults line;
  EncoderKind encoder = EncoderKind::None;
  bool backlash = false;
  bool interrupts_beyond_tolerance = false;  // exposure_doubt of the resin
  bool splits = false;                       // exposures in two pictures
  bool rises = false;                        // the plate rises above the layers, with a finer screw
  double rise_mm_s = 0;                      // highest speed of the rise
  int prints = 1;
  int layers = 2;
  Duration exposure{};
  Duration settle{}, rest{};
  std::vector<Happening> happenings;

  // True if there are no line faults and no happenings, so that the light must be as requested.
  [[nodiscard]] bool undisturbed() const;
  [[nodiscard]] bool has(std::initializer_list<Happening::Kind> any) const;
  [[nodiscard]] double steps_per_mm() const { return rises ? 800 : 80; }
  [[nodiscard]] Nanometers step() const { return Nanometers{rises ? 1'250 : 12'500}; }
  // Returns how far the plate may be from its reported place, including one motor step.
  [[nodiscard]] Nanometers plate_tolerance() const;
  // Returns how long after a safety input's first edge the light goes off; nullopt if that depends on other
  // failures.
  [[nodiscard]] std::optional<Duration> darkening_after_edge() const;
};

[[nodiscard]] Scenario draw_scenario(std::uint64_t seed);
[[nodiscard]] std::string describe(const Happening& happening);
[[nodiscard]] std::string describe(const Scenario& scenario);

}  // namespace contourd::rig
