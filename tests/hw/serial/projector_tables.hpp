// Projector tables for tests, as the reader of table files would make them. Pure functions.
#pragma once

#include <string>
#include <vector>

#include "hw/serial/projector_table.hpp"

namespace contourd::testing {

inline ProjectorCommand text_command(const std::string& name, const std::string& text,
                                     const std::vector<std::pair<ReplyMeaning, std::string>>& replies) {
  ProjectorCommand command{name, text + "\r", std::chrono::seconds{1}, {}};
  for (const auto& [meaning, expression] : replies)
    command.replies.push_back({meaning, ReplyPattern::of_line(expression)});
  return command;
}

inline ProjectorCommand hex_command(const std::string& name, const std::string& hex,
                                    const std::vector<std::pair<ReplyMeaning, std::string>>& replies) {
  std::optional<std::size_t> number_at;
  ProjectorCommand command{
      name, parse_hex_message(hex, Checksum::SumAfterFirst, number_at), std::chrono::seconds{1}, {}};
  for (const auto& [meaning, pattern] : replies)
    command.replies.push_back({meaning, ReplyPattern::of_bytes(pattern, Checksum::SumAfterFirst)});
  return command;
}

// Returns a short form of Optoma's table, if requested without its light commands.
inline ProjectorTable text_table(bool switches_light = true) {
  using M = ReplyMeaning;
  ProjectorTable table;
  table.name = "Optoma";
  table.gap = std::chrono::milliseconds{100};
  table.warm_up = std::chrono::seconds{30};
  table.cool_down = std::chrono::seconds{60};
  table.power_on = text_command("power on", "~0000 1", {{M::Accepted, "P"}, {M::Refused, "F"}});
  table.power_off = text_command("power off", "~0000 0", {{M::Accepted, "P"}, {M::Refused, "F"}});
  if (switches_light) {
    table.light_on = text_command("light on", "~0002 0", {{M::Accepted, "P"}, {M::Refused, "F"}});
    table.light_off = text_command("light off", "~0002 1", {{M::Accepted, "P"}, {M::Refused, "F"}});
  }
  table.power = text_command("power", "~00124 1", {{M::On, "OK1"}, {M::Off, "OK0"}});
  table.lamp_hours = text_command("lamp hours", "~00108 1", {{M::Value, "OK(\\d+)"}});
  table.unasked.push_back({ReplyPattern::of_line("INFO1"), "it is warming up", UnaskedLine::Kind::Nothing});
  table.unasked.push_back({ReplyPattern::of_line("INFO2"), "it is cooling down", UnaskedLine::Kind::Off});
  table.unasked.push_back({ReplyPattern::of_line("INFO4"), "the lamp failed", UnaskedLine::Kind::Fault});
  return table;
}

// Returns a short form of ViewSonic's table, with light commands.
inline ProjectorTable bytes_table() {
  using M = ReplyMeaning;
  const std::vector<std::pair<M, std::string>> yes_or_no{{M::Accepted, "03 14 00 00 00 sum"},
                                                         {M::Refused, "00 14 00 00 00 sum"}};
  ProjectorTable table = text_table();
  table.name = "ViewSonic";
  table.unasked.clear();
  table.power_on = hex_command("power on", "06 14 00 04 00 34 11 00 00 5D", yes_or_no);
  table.power_off = hex_command("power off", "06 14 00 04 00 34 11 01 00 5E", yes_or_no);
  table.light_on = hex_command("light on", "06 14 00 04 00 34 12 09 00 sum", yes_or_no);
  table.light_off = hex_command("light off", "06 14 00 04 00 34 12 09 01 sum", yes_or_no);
  table.power =
      hex_command("power", "07 14 00 05 00 34 00 00 11 00 5E",
                  {{M::On, "05 14 00 03 00 00 00 01 sum"}, {M::Off, "05 14 00 03 00 00 00 00 sum"}});
  table.lamp_hours = hex_command("lamp hours", "07 14 00 05 00 34 00 00 15 01 63",
                                 {{M::Value, "05 14 00 06 00 00 00 (..) (..) (..) (..) sum"}});
  return table;
}

}  // namespace contourd::testing
