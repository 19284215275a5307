#include "daemon/config/projector_table.hpp"

#include <array>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "daemon/config/json_document.hpp"
#include "daemon/config/json_schema.hpp"
#include "daemon/config/json_section.hpp"

namespace contourd {
namespace {

constexpr std::array<std::pair<const char*, ReplyMeaning>, 5> kReplies{{
    {"accepted", ReplyMeaning::Accepted},
    {"on", ReplyMeaning::On},
    {"off", ReplyMeaning::Off},
    {"value", ReplyMeaning::Value},
    {"refused", ReplyMeaning::Refused},  // last: it may be what is none of the others
}};

// What is sent, and where a number goes into it.
struct Message {
  std::string bytes;
  std::optional<std::size_t> number_at;
};

// A document that fits its schema, being read; what is wrong beyond the schema becomes a violation of it.
class TableReader {
 public:
  TableReader(JsonDocument& document, const JsonSection& root)
      : document_(document),
        root_(root),
        checksum_(root.text("checksum") == "none" ? Checksum::None : Checksum::SumAfterFirst) {}

  [[nodiscard]] ProjectorTable read();

 private:
  [[nodiscard]] ProjectorCommand command(const JsonSection& commands, const std::string& key);
  [[nodiscard]] std::optional<ProjectorCommand> optional_command(const JsonSection& commands,
                                                                 const std::string& key);
  [[nodiscard]] std::optional<BrightnessCommand> brightness(const JsonSection& commands);
  [[nodiscard]] Message message(const JsonSection& command, const std::string& place);
  [[nodiscard]] std::vector<ExpectedReply> replies(const JsonSection& command, const std::string& place);
  [[nodiscard]] std::vector<UnaskedLine> unasked();
  template <typename Parse>
  auto parsed(const std::string& place, const Parse& parse) -> std::optional<decltype(parse())>;
  void expect_values(const ReplyPattern& pattern, bool is_value, const std::string& place);

  JsonDocument& document_;
  const JsonSection& root_;
  Checksum checksum_;
};

// Nothing, and a violation, when it cannot be parsed.
template <typename Parse>
auto TableReader::parsed(const std::string& place, const Parse& parse) -> std::optional<decltype(parse())> {
  try {
    return parse();
  } catch (const std::invalid_argument& error) {
    document_.add_violation(place, error.what());
    return std::nullopt;
  }
}

Message TableReader::message(const JsonSection& command, const std::string& place) {
  Message message;
  if (command.has("hex")) {
    const std::string hex = command.text("hex");
    const auto bytes =
        parsed(place + "/hex", [&] { return parse_hex_message(hex, checksum_, message.number_at); });
    message.bytes = bytes.value_or("");
    return message;
  }
  message.bytes = command.text("text");
  const std::size_t at = message.bytes.find("{}");
  if (at != std::string::npos) {
    message.number_at = at;
    message.bytes.erase(at, 2);
  }
  message.bytes += root_.text("line_end");
  return message;
}

void TableReader::expect_values(const ReplyPattern& pattern, bool is_value, const std::string& place) {
  if (is_value && pattern.values() != 1) {
    document_.add_violation(place,
                            pattern.is_of_bytes()
                                ? "no byte of it is the value's: write (..) for each that is"
                                : "it has " + std::to_string(pattern.values()) +
                                      " groups; the value's digits need one, others are written (?:...)");
  }
  if (!is_value && pattern.values() != 0)
    document_.add_violation(place, pattern.is_of_bytes()
                                       ? "no value is expected here: write .. for any byte"
                                       : "no value is expected here: write groups as (?:...)");
}

std::vector<ExpectedReply> TableReader::replies(const JsonSection& command, const std::string& place) {
  const bool of_bytes = command.has("hex");
  std::vector<ExpectedReply> replies;
  for (const auto& [key, meaning] : kReplies) {
    if (!command.has(key)) continue;
    const std::string here = child_pointer(place, key);
    const std::string text = command.text(key);
    auto pattern = parsed(here, [&] {
      return of_bytes ? ReplyPattern::of_bytes(text, checksum_) : ReplyPattern::of_line(text);
    });
    if (!pattern) continue;
    expect_values(*pattern, meaning == ReplyMeaning::Value, here);
    replies.push_back({meaning, *std::move(pattern)});
  }
  return replies;
}

// "light off" for "light_off".
std::string spoken(std::string key) {
  for (char& c : key) {
    if (c == '_') c = ' ';
  }
  return key;
}

ProjectorCommand TableReader::command(const JsonSection& commands, const std::string& key) {
  const JsonSection section = commands.section(key);
  const std::string place = "/commands/" + key;
  Message sent = message(section, place);
  if (sent.number_at) document_.add_violation(place, "only the brightness has a number, {}, to put in");
  return {.name = spoken(key),
          .bytes = std::move(sent.bytes),
          .timeout = (section.has("timeout_ms") ? section : root_).duration("timeout_ms"),
          .replies = replies(section, place)};
}

std::optional<ProjectorCommand> TableReader::optional_command(const JsonSection& commands,
                                                              const std::string& key) {
  if (!commands.has(key)) return std::nullopt;
  return command(commands, key);
}

std::optional<BrightnessCommand> TableReader::brightness(const JsonSection& commands) {
  if (!commands.has("brightness")) return std::nullopt;
  const JsonSection section = commands.section("brightness");
  const std::string place = "/commands/brightness";
  Message sent = message(section, place);
  BrightnessCommand brightness;
  brightness.as_byte = section.has("hex");
  if (!sent.number_at && !sent.bytes.empty())
    document_.add_violation(place, "there is no {} in it, where the number goes");
  brightness.number_at = sent.number_at.value_or(0);
  brightness.checksum = brightness.as_byte ? checksum_ : Checksum::None;
  brightness.least = section.integer<std::int32_t>("minimum");
  brightness.most = section.integer<std::int32_t>("maximum");
  if (brightness.least > brightness.most)
    document_.add_violation(place + "/minimum", std::to_string(brightness.least) + " is more than maximum, " +
                                                    std::to_string(brightness.most));
  if (brightness.as_byte && brightness.most > 255)
    document_.add_violation(place + "/maximum",
                            std::to_string(brightness.most) + " does not fit in one byte");
  brightness.command = {.name = "brightness",
                        .bytes = std::move(sent.bytes),
                        .timeout = (section.has("timeout_ms") ? section : root_).duration("timeout_ms"),
                        .replies = replies(section, place)};
  return brightness;
}

std::vector<UnaskedLine> TableReader::unasked() {
  constexpr std::array<std::pair<const char*, UnaskedLine::Kind>, 4> kinds{{
      {"nothing", UnaskedLine::Kind::Nothing},
      {"off", UnaskedLine::Kind::Off},
      {"interruption", UnaskedLine::Kind::Interruption},
      {"fault", UnaskedLine::Kind::Fault},
  }};
  std::vector<UnaskedLine> lines;
  for (const JsonSection& section : root_.sections("unasked")) {
    const std::string place = "/unasked/" + std::to_string(lines.size()) + "/line";
    const std::string expression = section.text("line");
    const auto pattern = parsed(place, [&] { return ReplyPattern::of_line(expression); });
    UnaskedLine line{pattern.value_or(ReplyPattern()), section.text("means"), UnaskedLine::Kind::Nothing};
    for (const auto& [name, kind] : kinds) {
      if (section.text("is") == name) line.kind = kind;
    }
    lines.push_back(std::move(line));
  }
  return lines;
}

ProjectorTable TableReader::read() {
  const JsonSection commands = root_.section("commands");
  for (const auto& [one, other] : {std::pair{"light_on", "light_off"}, std::pair{"light_off", "light_on"}}) {
    if (commands.has(one) && !commands.has(other))
      document_.add_violation(std::string("/commands/") + one,
                              std::string("it needs ") + other + " beside it");
  }
  return {
      .name = root_.text("brand"),
      .baud = root_.integer<int>("baud"),
      .echo = root_.boolean("echo"),
      .retries = root_.integer<int>("retries"),
      .gap = root_.duration("gap_ms"),
      .warm_up = root_.duration("warm_up_s"),
      .cool_down = root_.duration("cool_down_s"),
      .power_on = command(commands, "power_on"),
      .power_off = command(commands, "power_off"),
      .light_on = optional_command(commands, "light_on"),
      .light_off = optional_command(commands, "light_off"),
      .brightness = brightness(commands),
      .power = optional_command(commands, "power"),
      .lamp_hours = optional_command(commands, "lamp_hours"),
      .unasked = unasked(),
  };
}

}  // namespace

ProjectorTable load_projector_table(const std::filesystem::path& path) {
  JsonDocument document = JsonDocument::from_file(path);
  projector_schema().check(document);
  document.throw_if_violated();
  const JsonSection root(document);
  ProjectorTable table = TableReader(document, root).read();
  document.throw_if_violated();
  return table;
}

}  // namespace contourd
