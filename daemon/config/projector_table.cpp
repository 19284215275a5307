#include "daemon/config/projector_table.hpp"

#include <algorithm>
#include <array>
#include <map>
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

constexpr std::array kCommands{"power_on",   "power_off", "light_on",  "light_off",
                               "brightness", "power",     "lamp_hours"};

// What is sent, and where a number goes into it.
struct Message {
  std::string bytes;
  std::optional<std::size_t> number_at;
};

[[nodiscard]] Checksum checksum_of_table(const std::string& name) {
  return name == "sum_after_first" ? Checksum::SumAfterFirst : Checksum::None;
}

Message parse_text(std::string text, const std::string& line_end) {
  Message message{std::move(text), std::nullopt};
  const std::size_t at = message.bytes.find("{}");
  if (at != std::string::npos) {
    message.number_at = at;
    message.bytes.erase(at, 2);
  }
  message.bytes += line_end;
  return message;
}

Message parse_hex(const std::string& hex, Checksum checksum) {
  Message message;
  message.bytes = parse_hex_message(hex, checksum, message.number_at);
  return message;
}

ReplyPattern parse_reply(const std::string& text, bool of_bytes, Checksum checksum) {
  return of_bytes ? ReplyPattern::of_bytes(text, checksum) : ReplyPattern::of_line(text);
}

// --- The rules beyond the schema, for what is sound of a document ---

// What `parse` returns; nothing, and a violation, when it throws.
template <typename Parse>
auto checked(JsonDocument& document, const std::string& place, const Parse& parse)
    -> std::optional<decltype(parse())> {
  try {
    return parse();
  } catch (const std::invalid_argument& error) {
    document.add_violation(place, error.what());
    return std::nullopt;
  }
}

std::string wrong_values(const ReplyPattern& pattern, bool is_value) {
  if (!is_value && pattern.values() != 0)
    return pattern.is_of_bytes() ? "no value is expected here: write .. for any byte"
                                 : "no value is expected here: write groups as (?:...)";
  if (!is_value || pattern.values() == 1) return {};
  if (pattern.is_of_bytes()) return "no byte of it is the value's: write (..) for each that is";
  return "it has " + std::to_string(pattern.values()) +
         " groups; the value's digits need one, others are written (?:...)";
}

void check_reply(JsonDocument& document, const std::string& place, bool of_bytes, bool is_value) {
  const auto text = document.sound_text(place);
  const auto checksum = document.sound_text("/checksum");
  if (!text || !checksum) return;
  const auto pattern =
      checked(document, place, [&] { return parse_reply(*text, of_bytes, checksum_of_table(*checksum)); });
  if (!pattern) return;
  const std::string wrong = wrong_values(*pattern, is_value);
  if (!wrong.empty()) document.add_violation(place, wrong);
}

void check_number(JsonDocument& document, const std::string& place, const Message& message) {
  const bool is_brightness = place == "/commands/brightness";
  if (message.number_at && !is_brightness)
    document.add_violation(place, "only the brightness has a number, {}, to put in");
  if (!message.number_at && is_brightness)
    document.add_violation(place, "there is no {} in it, where the number goes");
}

void check_command(JsonDocument& document, const std::string& place) {
  const auto hex = document.sound_text(place + "/hex"), text = document.sound_text(place + "/text");
  const auto checksum = document.sound_text("/checksum");
  if (hex && checksum) {
    const auto message =
        checked(document, place + "/hex", [&] { return parse_hex(*hex, checksum_of_table(*checksum)); });
    if (message) check_number(document, place, *message);
  } else if (text) {
    check_number(document, place, parse_text(*text, ""));
  }
  if (hex.has_value() == text.has_value()) return;  // what kind its replies are nobody knows
  for (const auto& [key, meaning] : kReplies)
    check_reply(document, child_pointer(place, key), hex.has_value(), meaning == ReplyMeaning::Value);
}

void check_brightness(JsonDocument& document) {
  const std::string place = "/commands/brightness";
  const auto least = document.sound_number(place + "/minimum"),
             most = document.sound_number(place + "/maximum");
  const auto plain = [](double whole) { return std::to_string(static_cast<std::int64_t>(whole)); };
  if (least && most && *least > *most)
    document.add_violation(place + "/minimum", plain(*least) + " is more than maximum, " + plain(*most));
  if (most && *most > 255 && document.sound_text(place + "/hex"))
    document.add_violation(place + "/maximum", plain(*most) + " does not fit in one byte");
}

void check_light(JsonDocument& document) {
  const auto has = [&](const char* key) {
    return document.value().contains(nlohmann::json::json_pointer(std::string("/commands/") + key));
  };
  for (const auto& [one, other] : {std::pair{"light_on", "light_off"}, std::pair{"light_off", "light_on"}}) {
    if (has(one) && !has(other))
      document.add_violation(std::string("/commands/") + one,
                             std::string("it needs ") + other + " beside it");
  }
}

void check_rules(JsonDocument& document) {
  for (const char* key : kCommands)
    check_command(document, std::string("/commands/") + key);
  check_brightness(document);
  check_light(document);
  const nlohmann::json::json_pointer unasked("/unasked");
  const std::size_t lines = document.value().contains(unasked) ? document.value().at(unasked).size() : 0;
  for (std::size_t i = 0; i < lines; ++i)
    check_reply(document, "/unasked/" + std::to_string(i) + "/line", false, false);
}

// --- Reading a document that is sound ---

class TableReader {
 public:
  explicit TableReader(JsonSection root)
      : root_(std::move(root)),
        commands_(root_.section("commands")),
        checksum_(checksum_of_table(root_.text("checksum"))) {}

  [[nodiscard]] ProjectorTable read() const;

 private:
  [[nodiscard]] Message message(const JsonSection& section) const;
  [[nodiscard]] ProjectorCommand command(const std::string& key) const;
  [[nodiscard]] std::optional<ProjectorCommand> optional_command(const std::string& key) const;
  [[nodiscard]] std::optional<BrightnessCommand> brightness() const;
  [[nodiscard]] std::vector<UnaskedLine> unasked() const;

  const JsonSection root_;
  const JsonSection commands_;
  const Checksum checksum_;
};

Message TableReader::message(const JsonSection& section) const {
  if (section.has("hex")) return parse_hex(section.text("hex"), checksum_);
  return parse_text(section.text("text"), root_.text("line_end"));
}

// "light off" for "light_off".
std::string spoken(std::string key) {
  std::replace(key.begin(), key.end(), '_', ' ');
  return key;
}

ProjectorCommand TableReader::command(const std::string& key) const {
  const JsonSection section = commands_.section(key);
  ProjectorCommand command{.name = spoken(key),
                           .bytes = message(section).bytes,
                           .timeout = (section.has("timeout_ms") ? section : root_).duration("timeout_ms"),
                           .replies = {}};
  for (const auto& [reply, meaning] : kReplies) {
    if (section.has(reply))
      command.replies.push_back({meaning, parse_reply(section.text(reply), section.has("hex"), checksum_)});
  }
  return command;
}

std::optional<ProjectorCommand> TableReader::optional_command(const std::string& key) const {
  if (!commands_.has(key)) return std::nullopt;
  return command(key);
}

std::optional<BrightnessCommand> TableReader::brightness() const {
  if (!commands_.has("brightness")) return std::nullopt;
  const JsonSection section = commands_.section("brightness");
  const bool as_byte = section.has("hex");
  return BrightnessCommand{.command = command("brightness"),
                           .number_at = message(section).number_at.value(),
                           .as_byte = as_byte,
                           .checksum = as_byte ? checksum_ : Checksum::None,
                           .least = section.integer<std::int32_t>("minimum"),
                           .most = section.integer<std::int32_t>("maximum")};
}

std::vector<UnaskedLine> TableReader::unasked() const {
  const std::map<std::string, UnaskedLine::Kind> kinds{{"nothing", UnaskedLine::Kind::Nothing},
                                                       {"off", UnaskedLine::Kind::Off},
                                                       {"interruption", UnaskedLine::Kind::Interruption},
                                                       {"fault", UnaskedLine::Kind::Fault}};
  std::vector<UnaskedLine> lines;
  for (const JsonSection& section : root_.sections("unasked"))
    lines.push_back(
        {ReplyPattern::of_line(section.text("line")), section.text("means"), kinds.at(section.text("is"))});
  return lines;
}

ProjectorTable TableReader::read() const {
  return {
      .name = root_.text("brand"),
      .baud = root_.integer<int>("baud"),
      .echo = root_.boolean("echo"),
      .retries = root_.integer<int>("retries"),
      .gap = root_.duration("gap_ms"),
      .warm_up = root_.duration("warm_up_s"),
      .cool_down = root_.duration("cool_down_s"),
      .power_on = command("power_on"),
      .power_off = command("power_off"),
      .light_on = optional_command("light_on"),
      .light_off = optional_command("light_off"),
      .brightness = brightness(),
      .power = optional_command("power"),
      .lamp_hours = optional_command("lamp_hours"),
      .unasked = unasked(),
  };
}

}  // namespace

ProjectorTable load_projector_table(const std::filesystem::path& path) {
  JsonDocument document = JsonDocument::from_file(path);
  projector_schema().check(document);
  check_rules(document);
  document.throw_if_violated();
  return TableReader(JsonSection(document)).read();
}

}  // namespace contourd
