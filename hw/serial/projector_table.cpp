#include "hw/serial/projector_table.hpp"

#include "core/contract/expects.hpp"

namespace contourd {

ProjectorCommand BrightnessCommand::with(std::int32_t number) const {
  expects(least <= number && number <= most, "the number is within the projector's range");
  ProjectorCommand numbered = command;
  if (as_byte) {
    numbered.bytes[number_at] = static_cast<char>(number);
  } else {
    numbered.bytes.insert(number_at, std::to_string(number));
  }
  if (checksum != Checksum::None) {
    numbered.bytes.pop_back();
    numbered.bytes += checksum_of(numbered.bytes, checksum);
  }
  return numbered;
}

Duration ProjectorTable::wire_time(const ProjectorCommand& command) const {
  // A start bit, 8 data bits, a stop bit.
  const auto bits = 10 * static_cast<std::int64_t>(command.bytes.size());
  return std::chrono::nanoseconds{std::int64_t{1'000'000'000} * bits / baud};
}

}  // namespace contourd
