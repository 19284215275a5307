// The serial protocol of a make of projector. Value types; config/projectors/*.json has the tables.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hw/clock.hpp"
#include "hw/serial/reply_pattern.hpp"

namespace contourd {

enum class ReplyMeaning { Accepted, Refused, On, Off, Value };

struct ExpectedReply {
  ReplyMeaning meaning;
  ReplyPattern pattern;
};

struct ProjectorCommand {
  std::string name;                    // "light off", for messages
  std::string bytes;                   // all that is sent, line end and checksum included
  Duration timeout{};                  // for its reply, from when the command was sent
  std::vector<ExpectedReply> replies;  // the first that fits counts; if empty, no reply is waited for
};

// A command with a number in it.
struct BrightnessCommand {
  ProjectorCommand command;  // the number is not in its bytes yet
  std::size_t number_at = 0;
  bool as_byte = false;  // the number replaces the one byte there; else its decimal digits are put in
  Checksum checksum = Checksum::None;
  std::int32_t least = 0;
  std::int32_t most = 0;

  // Returns the command with this number in it. REQUIRES: least <= number <= most.
  [[nodiscard]] ProjectorCommand with(std::int32_t number) const;
};

// A line that the projector sends by itself.
struct UnaskedLine {
  enum class Kind {
    Nothing,       // has no meaning for contourd
    Off,           // the projector has turned itself off: a fault, unless it was told to
    Interruption,  // see MachineEvent
    Fault,
  };
  ReplyPattern pattern;
  std::string means;  // a clause: "the lamp failed"
  Kind kind = Kind::Nothing;
};

struct ProjectorTable {
  std::string name;  // "Optoma"
  int baud = 9600;
  bool echo = false;     // every command comes back before its reply
  int retries = 2;       // after the first attempt
  Duration gap{};        // between a command or its reply and the next command, at least
  Duration latency{};    // from light on's first byte to its light, at least
  Duration warm_up{};    // from power on to light that can be used, at least
  Duration cool_down{};  // time after power off during which power on is ignored

  ProjectorCommand power_on, power_off;
  std::optional<ProjectorCommand> light_on,
      light_off;  // both or neither, but see LightConfig; each has an Accepted reply
  std::optional<BrightnessCommand> brightness;
  std::optional<ProjectorCommand> light;       // query: On, Off; only beside light_on
  std::optional<ProjectorCommand> power;       // query: On, Off
  std::optional<ProjectorCommand> lamp_hours;  // query: Value
  std::vector<UnaskedLine> unasked;

  // Returns how long the command is on the wire.
  [[nodiscard]] Duration wire_time(const ProjectorCommand& command) const;
  // True if the projector can switch its light. Otherwise the lamp shines as long as the projector is on, and
  // something else must make it dark.
  [[nodiscard]] bool switches_light() const { return light_on && light_off; }
};

}  // namespace contourd
