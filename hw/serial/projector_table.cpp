#include "hw/serial/projector_table.hpp"

namespace contourd {

ProjectorCommand BrightnessCommand::with(std::int32_t number) const {
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

}  // namespace contourd
