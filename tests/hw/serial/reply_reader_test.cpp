#include "hw/serial/reply_reader.hpp"

#include <rapidcheck.h>

#include <string>
#include <vector>

#include "tests/catch.hpp"
#include "tests/hw/serial/projector_tables.hpp"
#include "tests/hw/serial/scripted_channel.hpp"

using namespace contourd;
using namespace contourd::testing;
using namespace std::chrono_literals;

namespace {

constexpr TimePoint kNow{};
constexpr Duration kPatience{10s};
constexpr TimePoint kLater = kNow + kPatience;

// Returns the replies that a reader finds in these bytes, one string per reply.
std::vector<std::string> heard(ReplyReader& reader, const std::string& bytes, TimePoint now = kNow) {
  std::vector<std::string> all;
  for (const char byte : bytes) {
    const ReplyReader::Heard one = reader.take(byte, now);
    if (one.unasked != nullptr) all.push_back("unasked: " + one.unasked->means);
    if (one.reply) all.push_back(std::to_string(one.reply->request) + " " + one.reply->text);
  }
  return all;
}

using Words = std::vector<std::string>;

// A reader of the text table's replies.
struct TextReader {
  const ProjectorTable table = text_table();
  ReplyReader reader{table};
};

}  // namespace

TEST_CASE_METHOD(TextReader, "replies go to the oldest command that they fit") {
  reader.expect(1, table.power_on, kNow, kPatience);
  reader.expect(2, *table.power, kNow, kPatience);
  reader.expect(3, table.power_on, kNow, kPatience);
  CHECK(heard(reader, "P\rOK1\rP\rP\r") == Words{"1 P", "2 OK1", "3 P"});
}

TEST_CASE_METHOD(TextReader, "a command before one that was answered has gone unanswered") {
  reader.expect(1, table.power_on, kNow, kPatience);
  reader.expect(2, *table.power, kNow, kPatience);
  CHECK(heard(reader, "OK1\rP\r") == Words{"2 OK1"});
  CHECK(reader.unexplained() == "P\r");
}

TEST_CASE_METHOD(TextReader, "bytes that began to come before a command was sent are no reply to it") {
  SECTION("a line") {
    CHECK(heard(reader, "P").empty());
    reader.expect(1, *table.light_off, kNow, kPatience);
    SECTION("that ends after it") {
      CHECK(heard(reader, "\r").empty());
    }
    SECTION("that ends with silence") {
      CHECK_FALSE(reader.end_line(kNow).reply);
    }
    CHECK(heard(reader, "P\r") == Words{"1 P"});
  }
  SECTION("a line that belongs to the command before it") {
    reader.expect(1, table.power_on, kNow, kPatience);
    CHECK(heard(reader, "P").empty());
    reader.expect(2, *table.light_off, kNow, kPatience);
    CHECK(heard(reader, "\rP\r") == Words{"1 P", "2 P"});
  }
  SECTION("blanks, which do not begin a line") {
    CHECK(heard(reader, " \x7F").empty());
    reader.expect(1, *table.light_off, kNow, kPatience);
    CHECK(heard(reader, "P\r") == Words{"1 P"});
  }
  SECTION("bytes") {
    const ProjectorTable bytes = bytes_table();
    const std::string reply("\x03\x14\x00\x00\x00\x14", 6);
    for (std::size_t early = 0; early <= reply.size(); ++early) {
      CAPTURE(early);
      ReplyReader of_bytes(bytes);
      (void)heard(of_bytes, reply.substr(0, early));
      of_bytes.expect(1, bytes.power_on, kNow, kPatience);
      CHECK(heard(of_bytes, reply.substr(early)).size() == (early == 0 ? 1U : 0U));
    }
  }
}

TEST_CASE_METHOD(
    TextReader, "a reply is awaited as long as the previous one, and for its own time again after that one") {
  reader.expect(1, *table.light_on, kNow, 3 * kPatience);
  reader.expect(2, *table.light_off, kNow, kPatience);
  const TimePoint late = kNow + 2 * kPatience;
  CHECK(heard(reader, "P\r", late) == Words{"1 P"});
  CHECK(heard(reader, "P\r", late + kPatience) == Words{"2 P"});
  reader.expect(3, *table.light_on, kNow, 3 * kPatience);
  reader.expect(4, *table.light_off, kNow, kPatience);
  CHECK(heard(reader, "P\r", late) == Words{"3 P"});
  CHECK(heard(reader, "P\r", late + kPatience + 1ns).empty());
}

TEST_CASE("a reply is ambiguous if one like it was still due for another request when its command was sent") {
  const ProjectorTable table = text_table();
  const auto ambiguous = [&table](const ProjectorCommand& before, ReplyReader::RequestId id) {
    ReplyReader reader(table);
    reader.expect(1, before, kNow, kPatience);
    reader.expect(id, *table.light_off, kNow, kPatience);
    ReplyReader::Heard last;
    for (const char byte : std::string("P\rP\r")) {
      ReplyReader::Heard one = reader.take(byte, kNow);
      if (one.reply) last = std::move(one);
    }
    return last.reply.value().ambiguous;
  };
  CHECK(ambiguous(*table.light_on, 2));
  CHECK_FALSE(ambiguous(*table.light_on, 1));  // a repetition of the request
  CHECK_FALSE(ambiguous(*table.power, 2));     // a command with other replies
}

TEST_CASE("a reply is ambiguous while one like it may still answer a request that was sent more than once") {
  const ProjectorTable table = text_table();
  const auto ambiguous = [&table](int sent, TimePoint then) {
    ReplyReader reader(table);
    for (int i = 0; i < sent; ++i)
      reader.expect(1, table.power_on, kNow, kPatience);
    CHECK(heard(reader, "P\rP\r", kNow).size() == static_cast<std::size_t>(sent));
    std::size_t ambiguous_replies = 0;
    for (bool is_ambiguous = true; is_ambiguous; ambiguous_replies += is_ambiguous ? 1 : 0) {
      reader.expect(2, *table.light_off, then, kPatience);
      ReplyReader::Heard last;
      for (const char byte : std::string("P\r"))
        last = reader.take(byte, then);
      is_ambiguous = last.reply.value().ambiguous;
    }
    return ambiguous_replies;
  };
  CHECK(ambiguous(1, kNow) == 0);
  CHECK(ambiguous(2, kNow) == 2);  // each of the two may be repeated
  CHECK(ambiguous(2, kNow + kPatience + 1ns) == 0);
}

TEST_CASE_METHOD(
    TextReader,
    "after an ambiguous reply, the request's own reply may still come, and be taken for a later one's") {
  reader.expect(1, *table.light_off, kNow, kPatience);
  reader.expect(2, table.power_on, kNow, kPatience);
  CHECK(heard(reader, "F\rF\r") == Words{"1 F", "2 F"});  // both are light off's
  const auto ambiguous = [this](const std::string& bytes, TimePoint then) {
    ReplyReader::Heard last;
    for (const char byte : bytes)
      last = reader.take(byte, then);
    return last.reply.value().ambiguous;
  };
  SECTION("as long as it may come") {
    reader.expect(1, *table.light_off, kNow, kPatience);
    CHECK(ambiguous("P\r", kNow));  // power on's
    reader.expect(1, *table.light_off, kNow, kPatience);
    CHECK_FALSE(ambiguous("P\r", kNow));
  }
  SECTION("but no longer") {
    const TimePoint then = kNow + kPatience + 1ns;
    reader.expect(1, *table.light_off, then, kPatience);
    CHECK_FALSE(ambiguous("P\r", then));
  }
}

TEST_CASE_METHOD(TextReader, "a reply that comes too late is ignored") {
  reader.expect(1, table.power_on, kNow, kPatience);
  CHECK(heard(reader, "P\r", kLater + 1ns).empty());
  CHECK(heard(reader, "P\r").empty());
}

TEST_CASE_METHOD(TextReader,
                 "blanks, line feeds and NULs around a reply are not part of it, and count as explained") {
  reader.expect(1, table.power_on, kNow, kPatience);
  CHECK(heard(reader, std::string("\r\n \0P \r\n\0\r", 10)) == Words{"1 P"});
  CHECK(reader.unexplained().empty());
}

TEST_CASE("a command's echo is removed once, with the prompt before it") {
  ProjectorTable table = text_table();
  table.echo = true;
  table.power_on = text_command("power on", "\r*pow=on#", {{ReplyMeaning::Accepted, "\\*pow=on#"}});
  ReplyReader reader(table);
  reader.expect(1, table.power_on, kNow, kPatience);
  CHECK(heard(reader, ">*pow=on#\r\n").empty());
  CHECK(reader.unexplained().empty());
  CHECK(heard(reader, "*pow=on#\r") == Words{"1 *pow=on#"});
}

TEST_CASE("a raw command's echo is removed before its reply is looked for") {
  ProjectorTable table = bytes_table();
  table.echo = true;
  ReplyReader reader(table);
  reader.expect(1, table.power_on, kNow, kPatience);
  CHECK(heard(reader, table.power_on.bytes).empty());
  CHECK(reader.unexplained().empty());
  const std::string yes("\x03\x14\x00\x00\x00\x14", 6);
  CHECK(heard(reader, yes) == Words{"1 " + yes});
}

TEST_CASE("raw replies are found after noise, and not without their checksum") {
  const ProjectorTable table = bytes_table();
  ReplyReader reader(table);
  reader.expect(1, *table.power, kNow, kPatience);
  CHECK(heard(reader, std::string("\x05\x14\x00\x03\x00\x00\x00\x01\x19", 9)).empty());
  CHECK(heard(reader, std::string("\xff\x05\x14\x00\x03\x00\x00\x00\x01\x18", 10)).size() == 1);
}

TEST_CASE_METHOD(TextReader, "a line that never ends is cut, and its last bytes are kept to be shown") {
  reader.expect(1, table.power_on, kNow, kPatience);
  CHECK(heard(reader, std::string(10'000, 'x')).empty());
  CHECK(reader.unexplained() == std::string(64, 'x'));
  CHECK(heard(reader, "\rP\r") == Words{"1 P"});
}

TEST_CASE("the portions in which bytes come do not change the replies") {
  // Compares whole conversations in portions of any size with the same conversations in one portion.
  const auto converse = [](const ProjectorTable& table, const std::string& bytes,
                           const std::vector<std::size_t>& sizes) {
    ReplyReader reader(table);
    reader.expect(1, table.power_on, kNow, kPatience);
    reader.expect(2, *table.power, kNow, kPatience);
    reader.expect(3, *table.lamp_hours, kNow, kPatience);
    Words all;
    std::size_t at = 0;
    for (std::size_t i = 0; at < bytes.size(); ++i) {
      const std::size_t size = sizes.empty() ? bytes.size() : 1 + sizes[i % sizes.size()] % 7;
      for (const std::string& word : heard(reader, bytes.substr(at, size)))
        all.push_back(word);
      at += size;
    }
    all.push_back(reader.unexplained());
    return all;
  };
  const Words text_parts{"P\r", "OK1\r", "OK1234\r", "INFO1\r", "\xff\xfe", "F", "\r\n", "x"};
  const Words byte_parts{std::string("\x03\x14\x00\x00\x00\x14", 6),
                         std::string("\x05\x14\x00\x03\x00\x00\x00\x01\x18", 9),
                         std::string("\x05\x14\x00\x06\x00\x00\x00\x34\x12\x00\x00\x60", 12),
                         "\x05\x14",
                         "\xff",
                         "\r"};
  const ProjectorTable text = text_table(), bytes = bytes_table();
  CHECK(rc::check([&](const std::vector<std::size_t>& picks, const std::vector<std::size_t>& sizes) {
    std::string words, codes;
    for (const std::size_t pick : picks) {
      words += text_parts[pick % text_parts.size()];
      codes += byte_parts[pick % byte_parts.size()];
    }
    RC_ASSERT(converse(text, words, sizes) == converse(text, words, {}));
    RC_ASSERT(converse(bytes, codes, sizes) == converse(bytes, codes, {}));
  }));
}
