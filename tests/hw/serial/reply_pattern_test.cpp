#include "hw/serial/reply_pattern.hpp"

#include <stdexcept>
#include <string>

#include "hw/serial/projector_table.hpp"
#include "tests/catch.hpp"
#include "tests/hw/refusal.hpp"

using namespace contourd;

namespace {

std::string refusal_of_hex(const std::string& hex, Checksum checksum) {
  std::optional<std::size_t> number_at;
  return testing::refusal_of<std::invalid_argument>(
      [&] { return parse_hex_message(hex, checksum, number_at); });
}

}  // namespace

TEST_CASE("a line pattern matches the whole line, and its group is the value") {
  const ReplyPattern hours = ReplyPattern::of_line("OK(\\d+)");
  CHECK(hours.values() == 1);
  CHECK(hours.match_line("OK0042")->value == 42);
  CHECK_FALSE(hours.match_line("OK42 "));
  CHECK_FALSE(hours.match_line("xOK42"));
  CHECK_FALSE(hours.match_line("OK99999999999999999999"));  // no number that fits
  CHECK_FALSE(hours.match_end("OK42"));
}

TEST_CASE("a bytes pattern matches the end of what was received, and its value is little-endian") {
  const ReplyPattern hours = ReplyPattern::of_bytes("05 (..) (..) .. sum", Checksum::SumAfterFirst);
  const std::string reply = "\x05\x34\x12\x7f\xc5";  // 34 + 12 + 7f = c5
  CHECK(hours.match_end(reply)->value == 0x1234);
  CHECK(hours.match_end("noise" + reply)->value == 0x1234);
  CHECK_FALSE(hours.match_end(reply + "x"));
  CHECK_FALSE(hours.match_end(reply.substr(1)));
  CHECK_FALSE(hours.match_end(std::string("\x05\x34\x12\x7f\xc6")));
  CHECK_FALSE(hours.match_line(reply));
  const ReplyPattern high = ReplyPattern::of_bytes("(..) (..) (..) (..)", Checksum::None);
  CHECK(high.match_end("\xff\xff\xff\xff")->value == 0xffffffff);
}

TEST_CASE("a hex message's checksum is computed, or checked where it is written out") {
  std::optional<std::size_t> number_at;
  const std::string on =
      parse_hex_message("06 14 00 04 00 34 11 00 00 sum", Checksum::SumAfterFirst, number_at);
  CHECK(on == std::string("\x06\x14\x00\x04\x00\x34\x11\x00\x00\x5D", 10));
  CHECK_FALSE(number_at);
  CHECK(refusal_of_hex("06 14 00 04 00 34 11 00 00 5D", Checksum::SumAfterFirst).empty());
  CHECK(refusal_of_hex("06 14 5D", Checksum::SumAfterFirst) == "its last byte is 5D, but the checksum is 14");
  CHECK(refusal_of_hex("06 sum", Checksum::None) ==
        "\"sum\" stands for a checksum, but the table's checksum is \"none\"");
  CHECK(refusal_of_hex("sum 06", Checksum::SumAfterFirst) == "\"sum\" must come last");
  CHECK(refusal_of_hex(" ", Checksum::None) == "the text has no bytes");
  CHECK(refusal_of_hex("{} {}", Checksum::None) == "there is more than one {}");
  CHECK(refusal_of_hex("01 {} 02", Checksum::SumAfterFirst) ==
        "with a {} in it, its checksum must be \"sum\"");
  CHECK(refusal_of_hex("0x2A", Checksum::None).starts_with("\"0x2A\" is not a byte"));
}

TEST_CASE("a brightness goes in as digits or as a byte, and the checksum follows it") {
  BrightnessCommand text{
      .command = {.name = "brightness", .bytes = "CM+LEDS=\r\n", .timeout = {}, .replies = {}},
      .number_at = 8,
      .least = 0,
      .most = 1023};
  CHECK(text.with(7).bytes == "CM+LEDS=7\r\n");
  CHECK(text.with(1023).bytes == "CM+LEDS=1023\r\n");
  std::optional<std::size_t> number_at;
  BrightnessCommand hex;
  hex.command.bytes = parse_hex_message("2A 01 {} sum", Checksum::SumAfterFirst, number_at);
  hex.number_at = number_at.value();
  hex.as_byte = true;
  hex.most = 255;
  hex.checksum = Checksum::SumAfterFirst;
  CHECK(hex.with(0x80).bytes == "\x2A\x01\x80\x81");
}

TEST_CASE("bytes are readable in a message") {
  CHECK(readable_bytes("P\r\n") == "\"P\\r\\n\"");
  CHECK(readable_bytes(std::string("\x00\xff\"\\", 4)) == "\"\\x00\\xFF\\\"\\\\\"");
  CHECK(readable_bytes(std::string(33, 'a')) == "\"" + std::string(32, 'a') + "...\"");
}
