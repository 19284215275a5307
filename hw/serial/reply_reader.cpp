#include "hw/serial/reply_reader.hpp"

#include <algorithm>
#include <string_view>
#include <utility>

namespace contourd {
namespace {

constexpr std::size_t kLongestLine = 256;
constexpr std::size_t kMaxKept = 64;

std::string_view trimmed(std::string_view text) {
  const auto is_blank = [](char c) { return static_cast<unsigned char>(c) <= 0x20 || c == 0x7f; };
  while (!text.empty() && is_blank(text.front()))
    text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back()))
    text.remove_suffix(1);
  return text;
}

void keep_last(std::string& bytes, char next) {
  bytes += next;
  if (bytes.size() > kMaxKept) bytes.erase(0, bytes.size() - kMaxKept);
}

bool fits(const ProjectorCommand& command, bool line, std::string_view text) {
  return std::ranges::any_of(command.replies, [&](const ExpectedReply& expected) {
    return line ? expected.pattern.match_line(text).has_value()
                : expected.pattern.match_end(text).has_value();
  });
}

}  // namespace

void ReplyReader::expect(RequestId request, const ProjectorCommand& command, TimePoint sent,
                         Duration patience) {
  if (command.replies.empty() && !table_.echo) return;
  Owed next{.request = request,
            .command = &command,
            .bytes = table_.echo ? command.bytes : std::string(),
            .heard = heard_,
            .patience = patience,
            .before = {},
            .until = sent + patience};
  for (Owed& owed : owed_) {
    if (owed.request != request) next.before.push_back(owed.command);
    if (owed.request == request) next.repeated = owed.repeated = true;
  }
  for (const Repeat& repeat : repeats_) {
    if (repeat.request != request && repeat.until >= sent) next.before.push_back(repeat.command);
  }
  owed_.push_back(std::move(next));
}

// Drops the requests that can no longer be answered. As long as one may still be, so may all later ones.
void ReplyReader::give_up(TimePoint now) {
  const auto kept = std::ranges::find_if(owed_, [now](const Owed& owed) { return owed.until >= now; });
  owed_.erase(owed_.begin(), kept);
  std::erase_if(repeats_, [now](const Repeat& repeat) { return repeat.until < now; });
}

ReplyReader::Heard ReplyReader::take(char byte, TimePoint now) {
  give_up(now);
  if (trimmed(line_).empty()) line_begin_ = heard_;
  ++heard_;
  keep_last(received_, byte);
  keep_last(unexplained_, byte);
  const bool ends_line = byte == '\r' || byte == '\n';
  if (!ends_line) line_ += byte;
  if (is_echo(false)) return explained({});
  if (auto reply = match(false, received_, now)) return explained({std::move(reply), nullptr});
  return ends_line || line_.size() >= kLongestLine ? end_line(now) : Heard{};
}

ReplyReader::Heard ReplyReader::end_line(TimePoint now) {
  give_up(now);
  const bool echo = is_echo(true);
  const std::string whole = std::exchange(line_, {});
  const std::string_view line = trimmed(whole);
  if (line.empty()) {
    if (trimmed(unexplained_).empty()) unexplained_.clear();
    return {};
  }
  if (echo) return explained({});
  for (const UnaskedLine& unasked : table_.unasked) {
    if (unasked.pattern.match_line(line)) return explained({{}, &unasked});
  }
  if (auto reply = match(true, line, now)) return explained({std::move(reply), nullptr});
  return {};
}

// True if the bytes received end in a command's echo. A projector may put a prompt before the echo.
bool ReplyReader::is_echo(bool of_line) {
  for (Owed& owed : owed_) {
    const std::string_view sent = of_line ? trimmed(owed.bytes) : owed.bytes;
    if (sent.empty()) continue;
    const std::string_view heard = of_line ? trimmed(line_) : received_;
    if (!heard.ends_with(sent)) continue;
    owed.bytes.clear();
    return true;
  }
  return false;
}

std::optional<ReplyPattern::Match> ReplyReader::match(const Owed& owed, const ReplyPattern& pattern,
                                                      bool line, std::string_view text) const {
  if (line) return line_begin_ < owed.heard ? std::nullopt : pattern.match_line(text);
  const std::uint64_t since = std::min<std::uint64_t>(heard_ - owed.heard, text.size());
  return pattern.match_end(text.substr(text.size() - since));
}

std::optional<ReplyReader::Reply> ReplyReader::match(bool line, std::string_view text, TimePoint now) {
  for (auto owed = owed_.begin(); owed != owed_.end(); ++owed) {
    for (const ExpectedReply& expected : owed->command->replies) {
      const auto found = match(*owed, expected.pattern, line, text);
      if (!found) continue;
      Reply reply{owed->request, expected.meaning, found->value, std::string(text), false};
      reply.ambiguous = std::ranges::any_of(
          owed->before, [&](const ProjectorCommand* other) { return fits(*other, line, text); });
      const auto repeat = std::ranges::find_if(
          repeats_, [&](const Repeat& one) { return reply.ambiguous && fits(*one.command, line, text); });
      if (repeat != repeats_.end()) repeats_.erase(repeat);
      if (owed->repeated || reply.ambiguous)
        repeats_.push_back({owed->request, owed->command, now + owed->patience});
      owed_.erase(owed_.begin(), owed + 1);
      for (Owed& next : owed_)
        next.until = std::max(next.until, now + next.patience);
      return reply;
    }
  }
  return std::nullopt;
}

ReplyReader::Heard ReplyReader::explained(Heard heard) {
  line_.clear();
  received_.clear();
  unexplained_.clear();
  return heard;
}

}  // namespace contourd
