#include "daemon/config/projector_table.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "daemon/json/json_schema.hpp"

namespace contourd {
namespace {

constexpr std::array<std::pair<const char*, ReplyMeaning>, 5> kReplies{{
    {"accepted", ReplyMeaning::Accepted},
    {"on", ReplyMeaning::On},
    {"off", ReplyMeaning::Off},
    {"value", ReplyMeaning::Value},
    {"refused",
     ReplyMeaning::Refused},  // last: its pattern may match any reply that none of the others matches
}};

constexpr std::array kCommands{"power_on", "power_off",  "light_on", "light_off",
                               "light",    "brightness", "power",    "lamp_hours"};

// The limit in the schema.
constexpr Duration kLongestWarmUp = std::chrono::seconds{120};

// The bytes to send, and the offset at which a number is inserted.
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
  if (of_bytes) return ReplyPattern::of_bytes(text, checksum);
  try {
    return ReplyPattern::of_line(text);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(in_quotes(text) + " is not a regular expression: " + error.what());
  }
}

// --- Rules beyond the schema, for the valid parts of a document ---

// Returns the result of `parse`; if it throws, adds a violation and returns nullopt.
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
  if (pattern.is_of_bytes()) return "no byte is marked as the value: write (..) for each byte of it";
  return "it has " + std::to_string(pattern.values()) +
         " groups; write one group around the value's digits, and all others as (?:...)";
}

void check_reply(JsonDocument& document, const std::string& place, bool of_bytes, bool is_value) {
  const auto text = document.valid_text(place);
  const auto checksum = document.valid_text("/checksum");
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
    document.add_violation(place, "only the brightness command may contain {}, the place of a number");
  if (!message.number_at && is_brightness)
    document.add_violation(place, "it must contain {}, the place of the number");
}

void check_command(JsonDocument& document, const std::string& place) {
  const auto hex = document.valid_text(place + "/hex"), text = document.valid_text(place + "/text");
  const auto checksum = document.valid_text("/checksum");
  if (hex && checksum) {
    const auto message =
        checked(document, place + "/hex", [&] { return parse_hex(*hex, checksum_of_table(*checksum)); });
    if (message) check_number(document, place, *message);
  } else if (text) {
    check_number(document, place, parse_text(*text, ""));
  }
  if (hex.has_value() == text.has_value()) return;  // the kind of its replies is unknown
  for (const auto& [key, meaning] : kReplies)
    check_reply(document, child_pointer(place, key), hex.has_value(), meaning == ReplyMeaning::Value);
}

void check_brightness(JsonDocument& document) {
  const std::string place = "/commands/brightness";
  const auto least = document.valid_number(place + "/minimum"),
             most = document.valid_number(place + "/maximum");
  const auto plain = [](double whole) { return std::to_string(static_cast<std::int64_t>(whole)); };
  if (least && most && *least > *most)
    document.add_violation(place + "/minimum", plain(*least) + " is more than maximum, " + plain(*most));
  if (most && *most > 255 && document.valid_text(place + "/hex"))
    document.add_violation(place + "/maximum", plain(*most) + " does not fit in one byte");
}

void check_light(JsonDocument& document) {
  const auto has = [&](const char* key) {
    return document.value().contains(nlohmann::json::json_pointer(std::string("/commands/") + key));
  };
  for (const auto& [one, other] : {std::pair{"light_on", "light_off"}, std::pair{"light_off", "light_on"},
                                   std::pair{"light", "light_on"}}) {
    if (has(one) && !has(other))
      document.add_violation(std::string("/commands/") + one, std::string("it also needs ") + other);
  }
}

// Returns the hex digits in a comparable form: "2A0D" for "2a  0d".
std::string digits_of(std::string hex) {
  std::erase(hex, ' ');
  std::transform(hex.begin(), hex.end(), hex.begin(),
                 [](char c) { return c >= 'a' && c <= 'f' ? static_cast<char>(c - 'a' + 'A') : c; });
  return hex;
}

// Returns a line that a simple expression matches: the expression without escapes and without characters
// before '?'.
std::string plain_line(const std::string& expression) {
  std::string line;
  for (std::size_t i = 0; i < expression.size(); ++i) {
    const bool escape = expression[i] == '\\' && i + 1 < expression.size();
    if (escape) ++i;
    if (i + 1 < expression.size() && expression[i + 1] == '?') {
      ++i;
    } else {
      line += expression[i];
    }
  }
  return line;
}

// True if some reply matches both byte patterns.
bool overlap(const std::string& one, const std::string& other) {
  return one.size() == other.size() && std::equal(one.begin(), one.end(), other.begin(), [](char a, char b) {
           return a == b || a == '.' || b == '.';
         });
}

// A reply of a valid command: its text in the file and the parsed pattern.
struct WrittenReply {
  std::string text;
  ReplyPattern pattern;

  [[nodiscard]] bool fits_line_of(const WrittenReply& other) const {
    return text == other.text || pattern.match_line(other.text) || pattern.match_line(plain_line(other.text));
  }
};

// Returns the reply, or nullopt if there is none or its kind is unknown. The commands must have been checked.
std::optional<WrittenReply> written_reply(const JsonDocument& document, const std::string& command,
                                          const char* key) {
  const auto text = document.valid_text(command + "/" + key), checksum = document.valid_text("/checksum");
  const bool of_bytes = document.valid_text(command + "/hex").has_value();
  if (!text || !checksum || of_bytes == document.valid_text(command + "/text").has_value())
    return std::nullopt;
  try {
    return WrittenReply{*text, parse_reply(*text, of_bytes, checksum_of_table(*checksum))};
  } catch (const std::invalid_argument&) {
    return std::nullopt;  // already reported
  }
}

// Returns the wrong kind of reply that the pattern also matches; empty if there is none.
std::string wrongly_fitted(const WrittenReply& reply, const std::optional<WrittenReply>& refused) {
  if (reply.pattern.fits_noise()) return "noise";
  if (!refused) return "";
  // Byte patterns may overlap with the pattern for refusals, which may match anything that no other pattern
  // matches.
  const bool fits = reply.pattern.is_of_bytes() ? digits_of(reply.text) == digits_of(refused->text)
                                                : reply.fits_line_of(*refused);
  return fits ? "the reply \"refused\"" : "";
}

bool are_ambiguous(const WrittenReply& one, const WrittenReply& other) {
  if (one.pattern.is_of_bytes()) return overlap(digits_of(one.text), digits_of(other.text));
  return one.fits_line_of(other) || other.fits_line_of(one);
}

// Returns the bytes of a valid command.
std::optional<std::string> bytes_of(const JsonDocument& document, const std::string& place) {
  const auto hex = document.valid_text(place + "/hex"), text = document.valid_text(place + "/text");
  const auto checksum = document.valid_text("/checksum"), line_end = document.valid_text("/line_end");
  if (text && line_end) return parse_text(*text, *line_end).bytes;
  if (!hex || !checksum) return std::nullopt;
  return parse_hex(*hex, checksum_of_table(*checksum)).bytes;
}

constexpr const char* kTakenForOff = ": the light would be taken for off when it may be on";
constexpr const char* kTakenForOn = ": the light would be taken for on when it may be off";

void check_confirmation(JsonDocument& document, const std::string& command, const char* key,
                        const char* consequence) {
  const auto reply = written_reply(document, command, key);
  if (!reply) return;
  const std::string fitted = wrongly_fitted(*reply, written_reply(document, command, "refused"));
  if (!fitted.empty())
    document.add_violation(command + "/" + key,
                           in_quotes(reply->text) + " also matches " + fitted + consequence);
}

// Rejects replies that could confirm a wrong state of the light. Most important is darkness: neither
// light_off nor a question may take another reply for a confirmation that the light is off.
void check_light_replies(JsonDocument& document) {
  check_confirmation(document, "/commands/light_on", "accepted", kTakenForOn);
  check_confirmation(document, "/commands/light_off", "accepted", kTakenForOff);
  check_confirmation(document, "/commands/light", "on", kTakenForOn);
  for (const std::string question : {"/commands/light", "/commands/power"}) {
    check_confirmation(document, question, "off", kTakenForOff);
    const auto on = written_reply(document, question, "on"), off = written_reply(document, question, "off");
    if (on && off && !off->pattern.fits_noise() && are_ambiguous(*off, *on))
      document.add_violation(question + "/off",
                             in_quotes(off->text) + " also matches the reply \"on\"" + kTakenForOff);
  }
}

void check_different_bytes(JsonDocument& document, const std::string& off, const std::string& on) {
  const auto bytes = bytes_of(document, "/commands/" + off);
  if (bytes && bytes == bytes_of(document, "/commands/" + on))
    document.add_violation("/commands/" + off, "it sends the same bytes as " + on);
}

void check_rules(JsonDocument& document) {
  for (const char* key : kCommands)
    check_command(document, std::string("/commands/") + key);
  check_brightness(document);
  check_light(document);
  check_different_bytes(document, "power_off", "power_on");
  check_different_bytes(document, "light_off", "light_on");
  check_light_replies(document);
  const nlohmann::json::json_pointer unasked("/unasked");
  const std::size_t lines = document.value().contains(unasked) ? document.value().at(unasked).size() : 0;
  for (std::size_t i = 0; i < lines; ++i)
    check_reply(document, "/unasked/" + std::to_string(i) + "/line", false, false);
}

// --- Reading a valid document ---

class TableReader {
 public:
  explicit TableReader(JsonSection root)
      : root_(std::move(root)),
        commands_(root_.section("commands")),
        checksum_(checksum_of_table(root_.text("checksum"))) {}

  [[nodiscard]] ProjectorTable read() const;
  [[nodiscard]] std::optional<ProjectorTable> read_light() const;

 private:
  // Reads the settings of the serial line.
  [[nodiscard]] ProjectorTable read_line() const;
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

// Returns "light off" for "light_off".
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

ProjectorTable TableReader::read_line() const {
  ProjectorTable table;
  table.name = root_.text("brand");
  table.baud = root_.integer<int>("baud");
  table.echo = root_.boolean("echo");
  table.retries = root_.integer<int>("retries");
  table.gap = root_.duration("gap_ms");
  return table;
}

ProjectorTable TableReader::read() const {
  ProjectorTable table = read_line();
  table.latency = root_.duration("latency_ms");
  table.warm_up = root_.duration("warm_up_s");
  table.cool_down = root_.duration("cool_down_s");
  table.power_on = command("power_on");
  table.power_off = command("power_off");
  table.light_on = optional_command("light_on");
  table.light_off = optional_command("light_off");
  table.light = optional_command("light");
  table.brightness = brightness();
  table.power = optional_command("power");
  table.lamp_hours = optional_command("lamp_hours");
  table.unasked = unasked();
  return table;
}

std::optional<ProjectorTable> TableReader::read_light() const {
  if (!commands_.has("light_off")) return std::nullopt;
  ProjectorTable table = read_line();
  table.light_off = command("light_off");
  try {
    table.warm_up = root_.duration("warm_up_s");
  } catch (const std::exception&) {
    table.warm_up = kLongestWarmUp;
  }
  try {
    table.power = optional_command("power");
  } catch (const std::exception&) {
    // Without this command, a projector that does not confirm light off cannot be asked whether it is off
    // altogether.
  }
  return table;
}

}  // namespace

void check_table(JsonDocument& document) {
  projector_schema().check(document);
  check_rules(document);
}

ProjectorTable read_projector_table(const JsonSection& table) {
  return TableReader(table).read();
}

ProjectorTable load_projector_table(const std::filesystem::path& path) {
  JsonDocument document = JsonDocument::from_file(path);
  check_table(document);
  document.throw_if_violated();
  return read_projector_table(JsonSection(document));
}

std::optional<ProjectorTable> read_light_table(const JsonSection& table) {
  return TableReader(table).read_light();
}

}  // namespace contourd
