// The print process as one table: in which state which event leads where, and what is done on the way.
// Nothing else decides what happens next. `contourd --print-states` draws it.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace contourd {

enum class PrintState {
  Idle,
  WarmingUp,  // the lamp
  Homing,
  Lowering,  // the plate, to the layer's height
  Settling,  // the resin
  Showing,   // the mask, until the kernel says that it is on the screen
  Igniting,  // light on, until its command is sent
  Exposing,
  Darkening,      // light off is sent; black, until it is on the screen
  Extinguishing,  // until the light is confirmed off
  Interrupting,   // the same where the exposure was interrupted or cancelled
  Resting,        // before the peel
  Lifting,        // peel and lift
  AwaitingDark,   // before anything goes down into the resin: the light is confirmed off
  Raising,        // for a look at the part
  Paused,
  Held,     // interrupted before the first layer, where the plate's position may be unknown
  Braking,  // an interrupted print's move, to a standstill
  Halting,  // a cancelled print's move, to a standstill
  Parking,  // the plate goes up to its parking height
  Ending,   // all is over but that the light is confirmed off
};

enum class PrintEvent {
  Started,
  ProjectorReady,
  Homed,
  MoveEnded,
  WaitOver,
  MaskShown,
  LightOnSent,  // from here on there may be light
  ScreenBlack,
  LightIsOff,       // confirmed
  LayerDue,         // dark, and another layer is to come
  LayerUnfinished,  // dark, and the layer has not had all its light
  PauseDue,         // dark, and the owner asked for a pause or something interrupted the print
  LayersDone,       // dark after the last layer
  Interrupted,      // the lid was opened, the display lost: dark, up, and wait for the owner
  Resumed,
  Canceled,
  Failed,  // a device failed, did not answer in time, or an effect threw
  GaveUp,  // nobody has confirmed in time that the light is off
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
  AwaitDark,
  RecordLayer,  // if it is not yet: what remained of it may have been too little for a light of its own
  WaitToRest,
  Lift,
  NextLayer,
  RaiseForALook,
  Park,
  Finish,
};

struct PrintTransition {
  static constexpr std::size_t kMaxEffects = 6;

  PrintState from;
  PrintEvent on;
  PrintState to;
  std::array<PrintEffect, kMaxEffects> effects;  // in this order; LightOff always first
  std::size_t effect_count;

  [[nodiscard]] std::span<const PrintEffect> done() const { return std::span(effects).first(effect_count); }
};

// All rows. One that stays in its state only adds its effects: what the state waits for stays awaited.
[[nodiscard]] std::span<const PrintTransition> print_transitions();

// The row for an event in a state; nothing when the event means nothing there.
[[nodiscard]] const PrintTransition* find_transition(PrintState from, PrintEvent on);

[[nodiscard]] std::string_view name_of(PrintState state);
[[nodiscard]] std::string_view name_of(PrintEvent event);
[[nodiscard]] std::string_view name_of(PrintEffect effect);

// The table as a Graphviz graph; the rows for Failed, which are alike, drawn as one. Beside it those of a
// serial projector's power and light.
[[nodiscard]] std::string draw_print_states();

}  // namespace contourd
