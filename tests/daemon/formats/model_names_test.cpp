#include "daemon/formats/model_names.hpp"

#include <string_view>

#include "tests/catch.hpp"

TEST_CASE("A model's file is recognised by its extension, in either case") {
  CHECK(model_extension("part.stl") == ".stl");
  CHECK(model_extension("PART.StL") == ".stl");
  CHECK(model_extension("part.stl.gz") == ".stl.gz");
  CHECK(model_extension("part.OBJ.gz") == ".obj.gz");
  CHECK(model_extension("a.folder/part.zip") == ".zip");
  CHECK(model_extension("plate.SL1") == ".sl1");
  CHECK(model_extension("plate.sl1s") == ".sl1s");
  CHECK(model_extension("plate.SL1_svg") == ".sl1_svg");
  CHECK(model_extension("plate.NanoDLP") == ".nanodlp");
  for (const std::string_view name :
       {"part.stl.txt", "stl", ".stl", "part.tar.gz", "part.gz", ".stl.gz", "a.stl/b"})
    CHECK(model_extension(name).empty());
}

TEST_CASE("A model's name without its extension is the name of its job and its ticket") {
  CHECK(model_stem("part.stl") == "part");
  CHECK(model_stem("part.v2.STL.GZ") == "part.v2");
  CHECK(model_stem("folder/part.stl") == "folder/part");
  CHECK(model_stem("notes.txt") == "notes.txt");
}

TEST_CASE("No extension of a model ends with another one") {
  for (const std::string_view extension : model_extensions())
    for (const std::string_view other : model_extensions())
      CHECK((extension == other || !extension.ends_with(other)));
}
