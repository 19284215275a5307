#include "daemon/web/printer_answer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "daemon/web/printer/fetched_file.hpp"

namespace contourd::web {
namespace {

using Json = ControlLink::Json;

unsigned status_of(int code) {
  constexpr int kInvalidParameters = -32602, kRefused = -32000, kNotAllowed = -32001;
  switch (code) {
    case kInvalidParameters:
      return 400;
    case kRefused:
      return kConflict;
    case kNotAllowed:
      return 403;
    case ControlLink::kUnreachable:
      return 503;
    case kNoFile:
      return 502;
    default:
      return 500;
  }
}

struct ByteRange {
  std::optional<std::uint64_t> first, last;  // not both absent
};

// Returns the number; nullopt for any other text.
std::optional<std::uint64_t> number_in(std::string_view text) {
  std::uint64_t number = 0;
  const char* const end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, number);
  return read.ec == std::errc() && read.ptr == end ? std::optional(number) : std::nullopt;
}

// Returns the range of "bytes=FIRST-LAST", of which one number may be absent; nullopt for any other text.
std::optional<ByteRange> byte_range(std::string_view text) {
  constexpr std::string_view kUnit = "bytes=";
  if (!text.starts_with(kUnit)) return std::nullopt;
  text.remove_prefix(kUnit.size());
  const std::size_t dash = text.find('-');
  if (dash == std::string_view::npos) return std::nullopt;
  const std::string_view first = text.substr(0, dash), last = text.substr(dash + 1);
  const ByteRange range{number_in(first), number_in(last)};
  if ((!range.first && !first.empty()) || (!range.last && !last.empty())) return std::nullopt;
  if (!range.first && !range.last) return std::nullopt;
  if (range.first && range.last && *range.first > *range.last) return std::nullopt;
  return range;
}

}  // namespace

HttpReply reply_of(const Json& answer) {
  if (answer.contains("result"))
    return {.type = "application/json",
            .body = answer["result"].dump(-1, ' ', true, Json::error_handler_t::replace)};
  const Json& error = answer["error"];
  return {.status = status_of(error.value("code", 0)),
          .body = error.value("message", "contourd refuses") + "\n"};
}

HttpReply part_of(HttpReply whole, std::string_view range) {
  whole.headers.emplace_back("Accept-Ranges", "bytes");
  const std::optional<ByteRange> wanted = byte_range(range);
  if (!wanted || whole.body.empty()) return whole;
  const std::uint64_t bytes = whole.body.size();
  // Without a first byte, the last ones are wanted.
  const std::uint64_t first =
      wanted->first ? *wanted->first : bytes - std::min(bytes, wanted->last.value_or(0));
  const std::uint64_t last = wanted->first ? std::min(wanted->last.value_or(bytes), bytes - 1) : bytes - 1;
  if (first > last) {
    return {.status = 416,
            .body = fmt::format("the file has {} bytes\n", bytes),
            .headers = {{"Content-Range", fmt::format("bytes */{}", bytes)}}};
  }
  whole.status = 206;
  whole.headers.emplace_back("Content-Range", fmt::format("bytes {}-{}/{}", first, last, bytes));
  whole.body = whole.body.substr(first, last - first + 1);
  return whole;
}

}  // namespace contourd::web
