#include "daemon/web/printer_answer.hpp"

#include <algorithm>

#include "tests/catch.hpp"

namespace contourd::web {
namespace {

HttpReply ten_bytes(std::string_view range) {
  return part_of({.type = "video/mp4", .body = "0123456789"}, range);
}

std::string content_range(const HttpReply& reply) {
  const auto found =
      std::ranges::find(reply.headers, "Content-Range", &std::pair<std::string, std::string>::first);
  return found == reply.headers.end() ? "" : found->second;
}

}  // namespace

TEST_CASE("A browser gets the range of a film that it asks for") {
  const auto [range, body, told] =
      GENERATE(table<std::string, std::string, std::string>({{"bytes=0-", "0123456789", "bytes 0-9/10"},
                                                             {"bytes=0-1", "01", "bytes 0-1/10"},
                                                             {"bytes=4-4", "4", "bytes 4-4/10"},
                                                             {"bytes=8-99", "89", "bytes 8-9/10"},
                                                             {"bytes=-3", "789", "bytes 7-9/10"},
                                                             {"bytes=-99", "0123456789", "bytes 0-9/10"}}));
  const HttpReply reply = ten_bytes(range);
  CHECK(reply.status == 206);
  CHECK(reply.body == body);
  CHECK(content_range(reply) == told);
  CHECK(reply.type == "video/mp4");
}

TEST_CASE("A range beyond a film is refused with the film's size") {
  for (const char* range : {"bytes=10-", "bytes=99-100", "bytes=-0", "bytes=18446744073709551615-"}) {
    const HttpReply reply = ten_bytes(range);
    CHECK(reply.status == 416);
    CHECK(content_range(reply) == "bytes */10");
  }
}

TEST_CASE("A header that names no single range of bytes gets the whole film") {
  for (const char* range : {"", "bytes", "bytes=", "bytes=-", "bytes=5-2", "bytes=0-1,4-5", "lines=0-1",
                            "bytes=a-b", "bytes= 0-1", "bytes=+1-2", "bytes=0-99999999999999999999"}) {
    const HttpReply reply = ten_bytes(range);
    CHECK(reply.status == 200);
    CHECK(reply.body == "0123456789");
  }
}

}  // namespace contourd::web
