// The print process as one table: in which state which event leads where, and what is done on the way.
// Nothing else decides what happens next. `contourd --print-states` draws it.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace contourd {

// In the order of a print: what comes after Exposing comes after it in every layer.
enum class PrintState {
  Idle,
  WarmingUp,  // the lamp
  Homing,
  Lowering,  // the plate, to the layer's height
  Settling,  // the resin
  Showing,   // the mask, until the kernel says that it is on the screen
  Igniting,  // light on, until the projector says so
  Exposing,
  Darkening,  // light is off; black, until it is on the screen
  Resting,    // before the peel
  Lifting,    // peel and lift
  Raising,    // for a look at the part
  Paused,
  Halting,  // a cancelled print's move, to a standstill
  Parking,  // the plate goes up to its parking height; then the print is over
};

enum class PrintEvent {
  Started,
  ProjectorReady,
  Homed,
  MoveEnded,
  WaitOver,
  MaskShown,
  LightIsOn,
  ScreenBlack,
  LayerDue,    // lifted, and another layer is to come
  PauseDue,    // lifted, and the owner asked for a pause
  LayersDone,  // lifted after the last layer
  Resumed,
  Canceled,
  Failed,  // a device failed, did not answer in time, or an effect threw
};

enum class PrintEffect {
  LightOff,
  BlackNow,
  AbortAxis,
  StopAxis,
  PowerOn,
  PowerOff,
  Home,
  LowerToLayer,
  WaitToSettle,
  ShowMask,
  LightOn,
  TimeExposure,
  ShowBlack,
  RecordLayer,
  WaitToRest,
  Lift,
  NextLayer,
  RaiseForALook,
  Park,
  Finish,
};

struct PrintTransition {
  static constexpr std::size_t kMostEffects = 5;

  PrintState from;
  PrintEvent on;
  PrintState to;
  std::array<PrintEffect, kMostEffects> effects;  // in this order; LightOff always first
  std::size_t effect_count;

  [[nodiscard]] std::span<const PrintEffect> done() const { return std::span(effects).first(effect_count); }
};

// All rows.
[[nodiscard]] std::span<const PrintTransition> print_transitions();

// The row for an event in a state; nothing when the event means nothing there.
[[nodiscard]] const PrintTransition* find_transition(PrintState from, PrintEvent on);

[[nodiscard]] std::string_view name_of(PrintState state);
[[nodiscard]] std::string_view name_of(PrintEvent event);
[[nodiscard]] std::string_view name_of(PrintEffect effect);

// The table as a Graphviz graph; the rows for Failed, which are alike, drawn as one.
[[nodiscard]] std::string draw_print_states();

}  // namespace contourd
