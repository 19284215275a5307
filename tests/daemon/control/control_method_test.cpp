#include "daemon/control/control_method.hpp"

#include "tests/catch.hpp"
#include "tests/message_of.hpp"

using Json = ControlMethod::Json;
using Parameter = ControlParameter;

namespace {

ControlMethod move_method() {
  ControlParameter place = Parameter::whole_number("to", 1, 9, "the place");
  place.words = {"last"};
  return {.description = "Moves.",
          .parameters = {Parameter::text("job", "the job").described_as("the name of a job").needed(), place,
                         Parameter::number("speed", 0.5, 2, "mm/s", "the speed"),
                         Parameter::one_of("power", {"on", "off"}, "the power"),
                         Parameter::flag("now", "at once")},
          .changes = true};
}

// Returns why the parameters are refused, or an empty text.
std::string move_refusal(const Json& parameters) {
  return testing::message_of<InvalidParameters>([&] {
    const Json checked = move_method().check("move", parameters);
    CHECK(checked == parameters);
  });
}

}  // namespace

TEST_CASE("A parameter's value is refused by a sentence with its valid values") {
  const Json job{{"job", "gear"}};
  CHECK(move_refusal(job).empty());
  for (const Json& wrong : {Json(), Json(""), Json(1), Json::array()})
    CHECK(move_refusal({{"job", wrong}}) == "job must be the name of a job");
  const auto refusal = [&](const char* name, const Json& value) {
    Json parameters = job;
    parameters[name] = value;
    return move_refusal(parameters);
  };
  for (const Json& right : {Json(1), Json(9), Json("last")})
    CHECK(refusal("to", right).empty());
  for (const Json& wrong : {Json(0), Json(10), Json(1.5), Json(1e300), Json("first"), Json(), Json(true)})
    CHECK(refusal("to", wrong) == "to must be a whole number from 1 to 9");
  for (const Json& right : {Json(0.5), Json(2)})
    CHECK(refusal("speed", right).empty());
  for (const Json& wrong : {Json(0.49), Json(2.01), Json("1"), Json(), Json(true)})
    CHECK(refusal("speed", wrong) == "speed must be a number from 0.5 to 2 mm/s");
  CHECK(refusal("power", "off").empty());
  for (const Json& wrong : {Json("of"), Json(""), Json(1)})
    CHECK(refusal("power", wrong) == "power must be one of on, off");
  CHECK(refusal("now", false).empty());
  for (const Json& wrong : {Json(0), Json("true"), Json()})
    CHECK(refusal("now", wrong) == "now must be true or false");
}

TEST_CASE("A method refuses unknown, unnamed and missing parameters") {
  CHECK(move_refusal({{"job", "gear"}, {"at", 1}}) ==
        R"(the method "move" has no parameter "at"; there are job, to, speed, power, now)");
  CHECK(move_refusal(Json::array({1})) ==
        R"(the method "move" takes its parameters by name: job, to, speed, power, now)");
  CHECK(move_refusal(Json::object()) == "job must be the name of a job");
  CHECK(move_refusal(Json()) == "job must be the name of a job");
  CHECK(ControlMethod{}.check("stop", Json()) == Json::object());
  CHECK_THROWS_AS(ControlMethod{}.check("stop", {{"at", 1}}), InvalidParameters);
}

TEST_CASE("The description of methods has each parameter with its limits") {
  const Json methods = describe({{"move", move_method()}})["methods"];
  REQUIRE(methods.size() == 1);
  CHECK(methods[0]["name"] == "move");
  CHECK(methods[0]["description"] == "Moves.");
  CHECK(methods[0]["changes"] == true);
  CHECK(methods[0]["needs_service_rights"] == false);
  const Json& parameters = methods[0]["parameters"];
  REQUIRE(parameters.size() == 5);
  CHECK(parameters[0]["needed"] == true);
  CHECK(parameters[0]["least"].is_null());
  CHECK(parameters[1]["most"] == 9);
  CHECK(parameters[1]["words"] == Json{"last"});
  CHECK(parameters[2]["must_be"] == "a number from 0.5 to 2 mm/s");
  CHECK(parameters[3]["words"] == Json{"on", "off"});
  CHECK(parameters[4]["meaning"] == "at once");
}
