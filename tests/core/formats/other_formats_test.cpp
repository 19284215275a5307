#include "core/formats/other_formats.hpp"

#include <string>
#include <string_view>

#include "core/formats/model_reader.hpp"
#include "tests/catch.hpp"
#include "tests/message_of.hpp"
#include "tests/models/models.hpp"

namespace {

using std::string_view_literals::operator""sv;

std::string refusal_of_text(std::string_view bytes) {
  return testing::message_of<ModelError>([&] { (void)(read_model(std::as_bytes(std::span(bytes)))); });
}

}  // namespace

TEST_CASE("Files of other formats are refused by what they are") {
  struct Case {
    std::string_view start;
    const char* name;
    const char* advice;
  };
  const Case cases[]{
      {"\x1F\x8B\x08\x00\x00", "gzip", "unpack"},
      {"PK\x03\x04\x14\x00\x00\x00\x08\x00part.stl"sv, "ZIP", "unpack"},
      {"PK\x03\x04\x14\x00\x00\x00\x08\x00[Content_Types].xml"sv, "3MF", "export"},
      {"PK\x03\x04\x14\x00\x00\x00\x08\x00"
       "3D/3dmodel.model"sv,
       "3MF", "export"},
      {"PK\x03\x04\x14\x00\x00\x00\x08\x00"
       "config.ini"sv,
       "SL1", "sliced"},
      {"\x86\x00\xFD\x12\x00\x00"sv, ".ctb", "sliced"},
      {"%PDF-1.4\n", "PDF", "download"},
      {"  <!DOCTYPE html>\n<html>", "web page", "download"},
      {"\xEF\xBB\xBF<HTML lang=en>", "web page", "download"},
      {"\xFF\xFEs\x00o\x00l\x00"sv, "UTF-16", "plain text"},
      {"version https://git-lfs.github.com/spec/v1\noid", "Git LFS", "git lfs pull"},
      {"ISO-10303-21;\nHEADER;", "STEP", "export"},
      {"ply\nformat ascii 1.0\n", "PLY", "export"},
  };
  for (const Case& each : cases) {
    // Short files and long ones: the sentence does not depend on a facet count that a header would claim.
    for (const std::size_t more : {std::size_t{0}, std::size_t{300}, std::size_t{5000}}) {
      CAPTURE(each.name, more);
      const std::string bytes = std::string(each.start) + std::string(more, 'x');
      CHECK(lacking(refusal_of_text(bytes), {"not an STL file but", each.name, each.advice}) == "");
    }
  }
}

TEST_CASE("A binary STL file is read whatever its header begins with") {
  const models::Facets facets = models::box({0, 0, 0}, {1, 1, 1});
  for (const std::string_view header :
       {"PK\x03\x04"sv, "%PDF-1.4"sv, "\x1F\x8B"sv, "<html>"sv, "v 1 2 3\n"sv, "{"sv}) {
    std::vector<std::byte> bytes = models::to_binary_stl(facets);
    std::ranges::copy(std::as_bytes(std::span(header)), bytes.begin());
    CHECK(read_model(bytes).facets.size() == facets.size());
  }
}

TEST_CASE("ASCII STL is not taken for another format, whatever its comments and names are") {
  const std::string text = models::to_ascii_stl(models::box({0, 0, 0}, {1, 1, 1}));
  for (const std::string_view start : {"# v 1 2 3\n", "\n# OBJ\n", "\xEF\xBB\xBF"}) {
    CAPTURE(start);
    CHECK(refusal_of_text(std::string(start) + text) == "");
  }
}

TEST_CASE("Text that is no known format is refused as text, not as a damaged binary file") {
  const std::string prose = "The quick brown fox jumps over the lazy dog.\n";
  for (const std::string& text : {std::string("hello world"), prose + prose + prose, "# a comment\n" + prose,
                                  std::string("# only a comment\n"),
                                  std::string("V 0 0 0\nV 1 0 0\nV 0 1 0\nF 1 2 3\n") + std::string(400, ' '),
                                  "Gr\xC3\xB6\xC3\x9F"
                                  "e\n" +
                                      prose + prose}) {
    CAPTURE(text);
    CHECK(lacking(refusal_of_text(text), {"not an STL file but text", "export"}) == "");
  }
}

TEST_CASE("Comments of any usual length may come before the facets of an ASCII file") {
  std::string comments;
  for (int i = 0; i < 1000; ++i)
    comments += "# a line of the licence, which is no part of the model\n";
  const models::Facets box = models::box({0, 0, 0}, {1, 1, 1});
  CHECK(refusal_of_text(comments + models::to_ascii_stl(box)) == "");
  CHECK(lacking(refusal_of_text(comments + "hello"), {"not an STL file but text"}) == "");
}
