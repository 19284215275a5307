#include "daemon/system/base64.hpp"

#include "tests/catch.hpp"

namespace {

std::vector<std::uint8_t> bytes_of(const std::string& text) {
  return {text.begin(), text.end()};
}

}  // namespace

// RFC 4648, section 10.
TEST_CASE("Base64 encodes and decodes the test vectors of RFC 4648") {
  const std::vector<std::pair<std::string, std::string>> vectors{{"", ""},
                                                                 {"f", "Zg=="},
                                                                 {"fo", "Zm8="},
                                                                 {"foo", "Zm9v"},
                                                                 {"foob", "Zm9vYg=="},
                                                                 {"fooba", "Zm9vYmE="},
                                                                 {"foobar", "Zm9vYmFy"}};
  for (const auto& [plain, text] : vectors) {
    CAPTURE(plain);
    CHECK(base64(bytes_of(plain)) == text);
    CHECK(from_base64(text) == bytes_of(plain));
  }
}

TEST_CASE("Base64 decodes every byte to itself, at every offset") {
  for (std::size_t length = 1; length <= 4; ++length) {
    for (int value = 0; value < 256; ++value) {
      const std::vector<std::uint8_t> bytes(length, static_cast<std::uint8_t>(value));
      CHECK(from_base64(base64(bytes)) == bytes);
    }
  }
}

TEST_CASE("Text that is not Base64, or not the canonical encoding of its bytes, is rejected") {
  for (const char* wrong : {"A", "AA", "AAA", "AAAAA", "====", "A===", "=AAA", "AA=A", "AA==AAAA", "AAA ",
                            "AA-_", "AB==", "AAB=", "AAA\xe4"}) {
    CAPTURE(wrong);
    CHECK_FALSE(from_base64(wrong));
  }
}
