#include "daemon/prepare/mesh_repair_text.hpp"

#include "core/model/height_index.hpp"
#include "tests/catch.hpp"

TEST_CASE("Repairs are described with their numbers, and no repairs as an empty text") {
  CHECK(describe(MeshRepairs{}).empty());
  CHECK(describe(MeshRepairs{17, 0, 0, 0}) == "17 facets turned round");
  CHECK(describe(MeshRepairs{1, 1, 0, 0}) == "1 facet turned round, 1 duplicate facet removed");
  CHECK(describe(MeshRepairs{0, 0, 3, 4}) ==
        "3 reversed duplicate facets removed, 4 inner wall facets removed");
}

TEST_CASE("A warning names each change to a mesh") {
  CHECK(mesh_warnings(false, {}).empty());
  CHECK(mesh_warnings(true, {2, 0, 0, 0}) ==
        std::vector<std::string>{std::string(kTurnedOutwardsWarning),
                                 "the model's facets disagree with each other: 2 facets turned round"});
}

TEST_CASE("The JSON of repairs has every figure") {
  CHECK(repairs_json({1, 2, 3, 4}).dump() ==
        R"({"turned_facets":1,"doubled_facets":2,"reversed_facets":3,"inner_wall_facets":4})");
}
