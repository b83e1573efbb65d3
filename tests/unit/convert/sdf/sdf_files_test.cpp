// Test of includes and URIs of SDF files, and of damaged and hostile files.
#include <cstdlib>
#include <new>
#include <optional>

#include "convert/sdf/library/sdf_trial.h"
#include "tests/unit/convert/sdf/sdf_fixture.h"

namespace fire3dv::convert {
namespace {

// Value of an environment variable for the life of the object.
class Variable {
 public:
  Variable(const char* name, const std::string& value) : name_(name) {
    if (const char* before = std::getenv(name)) before_ = before;
    ::setenv(name, value.c_str(), 1);
  }
  ~Variable() {
    if (before_)
      ::setenv(name_, before_->c_str(), 1);
    else
      ::unsetenv(name_);
  }

 private:
  const char* name_;
  std::optional<std::string> before_;
};

class SdfIncludes : public Sdf {
 protected:
  void write_crate(const std::string& folder, const std::string& version = "1.6") {
    write(folder + "/model.config",
          "<model><name>crate</name><sdf version='" + version + "'>model.sdf</sdf></model>");
    write(folder + "/model.sdf", "<sdf version='" + version + "'><model name='crate'>" +
                                     link("l", visual("<mesh><uri>meshes/t.obj</uri></mesh>")) +
                                     "</model></sdf>");
    write(folder + "/meshes/t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  }
  static std::string include(const std::string& uri, const std::string& more = "") {
    return "<include><uri>" + uri + "</uri>" + more + "</include>\n";
  }
};

TEST_F(SdfIncludes, GazeboVariablesAreSearched) {
  write_crate("assets/crate");
  for (const char* name :
       {"GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH", "SDF_PATH", "GAZEBO_MODEL_PATH"}) {
    const Variable path(name, "/nowhere:" + (folder_.path() / "assets").string());
    const Model model = read(include("model://crate", "<name>first</name><pose>1 2 3 0 0 0</pose>") +
                             include("package://crate/model.sdf", "<name>second</name>"));
    EXPECT_EQ(warnings(model), "") << name;
    expect_near(glm::dvec3(pose_of(model, "first/l/v")[3]), {1, 2, 3});
    // The URI of the mesh is relative to the included file.
    EXPECT_EQ(surface(model, "second/l/v").positions.size(), 3u);
  }
}

TEST_F(SdfIncludes, FoldersAreSearched) {
  write_crate("models/crate");
  EXPECT_EQ(warnings(read(include("models/crate"))), "");
  EXPECT_EQ(warnings(read(include("file://models/crate/model.sdf"))), "");
  EXPECT_EQ(warnings(read(include("file://" + (folder_.path() / "models/crate").string()))), "");
  ReadOptions options;
  options.package_folders = {folder_.path() / "models"};
  EXPECT_EQ(warnings(read(include("model://crate"), options)), "");
}

TEST_F(SdfIncludes, AreFoundInFuelsCache) {
  write_crate("fuel/fuel.gazebosim.org/some one/models/big crate/2");
  write_crate("fuel/fuel.gazebosim.org/some one/models/big crate/10", "1.9");
  const Variable cache("GZ_FUEL_CACHE_PATH", (folder_.path() / "fuel").string());
  const std::string uri = "https://fuel.gazebosim.org/1.0/Some One/models/Big Crate";
  for (const std::string end : {"", "/2", "/tip/files/model.sdf"})
    EXPECT_EQ(warnings(read(include(uri + end))), "") << end;
  const Model model = read(include("https://fuel.gazebosim.org/1.0/Some One/models/Other"));
  EXPECT_TRUE(warns(model, "nothing is downloaded: fetch it with \"gz fuel download -u https://"))
      << warnings(model);
}

// By model://, and by a URI without the version of the interface.
TEST_F(SdfIncludes, DownloadedModelsNeedNoOwner) {
  write_crate("fuel/fuel.gazebosim.org/some one/models/big crate/2");
  const Variable cache("GZ_FUEL_CACHE_PATH", (folder_.path() / "fuel").string());
  EXPECT_EQ(warnings(read(include("model://Big Crate"))), "");
  EXPECT_EQ(warnings(read(include("https://fuel.gazebosim.org/Some One/models/Big Crate/2"))), "");
}

TEST_F(SdfIncludes, ForeignPathsMatchBySuffix) {
  write_crate("models/crate");
  write("models/model.sdf", "no description");
  const Variable path("GZ_SIM_RESOURCE_PATH", (folder_.path() / "models").string());
  for (const std::string uri : {"/home/somebody/ws/crate/model.sdf", "file:///far/crate/model.sdf"}) {
    const Model model = read(include(uri));
    EXPECT_EQ(warnings(model), "");
    EXPECT_TRUE(node(model, "crate/l/v")) << uri;
  }
  // The name of a file alone says too little.
  EXPECT_TRUE(warns(read(include("/home/somebody/model.sdf")), "its end is not found in"));
}

// Security: a confined SDF file names files outside of its folder.
TEST_F(SdfIncludes, ConfinedReadsNamedFoldersOnly) {
  write_crate("private/crate");
  write_crate("near/crate");
  const test::ScratchFolder others;
  std::filesystem::rename(folder_.path() / "private", others.path() / "private");
  ReadOptions confined, named;
  confined.is_confined = named.is_confined = true;
  named.package_folders = {others.path() / "private"};
  const std::string file = "file://" + (others.path() / "private/crate/model.sdf").string();
  EXPECT_TRUE(warns(read(include(file), confined), "lies outside the folders that a stranger may name"));
  EXPECT_EQ(warnings(read(include(file), named)), "");
  EXPECT_EQ(warnings(read(include(file))), "") << "the user's own file";
  const std::string above = "../" + others.path().filename().string() + "/private/crate";
  EXPECT_NE(warnings(read(include(above), confined)), "");
  EXPECT_EQ(warnings(read(include("near/crate"), confined)), "") << "below the folder of the description";
}

TEST_F(SdfIncludes, MissingNamesFoldersAndRemedy) {
  const Variable path("GZ_SIM_RESOURCE_PATH", "/nowhere/a:/nowhere/b");
  const Model model = read("\n" + include("model://gone"));
  const std::string said = warnings(model);
  EXPECT_NE(
      said.find("world.sdf, line 5: <include> is left out: \"model://gone\" is not found in \"/nowhere/a\" "
                "(GZ_SIM_RESOURCE_PATH), \"/nowhere/b\" (GZ_SIM_RESOURCE_PATH)"),
      std::string::npos)
      << said;
  EXPECT_NE(said.find("set GZ_SIM_RESOURCE_PATH"), std::string::npos) << said;
  EXPECT_TRUE(model.sources.contains("/nowhere/a/gone"));
}

TEST_F(SdfIncludes, NestedModelsAreMerged) {
  write("part/model.config", "<model><sdf version='1.9'>p.sdf</sdf></model>");
  write("part/p.sdf",
        "<sdf version='1.9'><model name='part'>" + link("inner", visual("<sphere/>")) + "</model></sdf>");
  const Model model = read(
      model_of("m", "<include merge='true'><uri>part</uri><pose>0 0 7 0 0 0</pose></include>" + link("own")));
  ASSERT_TRUE(node(model, "m/inner")) << warnings(model);
  expect_near(glm::dvec3(pose_of(model, "m/inner")[3]), {0, 0, 7});
}

TEST_F(SdfIncludes, ThatLoopAreLeftOut) {
  write("a/model.config", "<model><sdf version='1.9'>a.sdf</sdf></model>");
  write("a/a.sdf",
        "<sdf version='1.9'><model name='a'>" + link("l") + include("../b/b.sdf") + "</model></sdf>");
  write("b/b.sdf", "<sdf version='1.9'><model name='b'>" + link("l") + include("../a") + "</model></sdf>");
  const Model model = read(include("a"));
  EXPECT_TRUE(warns(model, "includes itself, over others")) << warnings(model);
  EXPECT_TRUE(node(model, "a/b/l")) << warnings(model);
}

// 4^10 models.
TEST_F(SdfIncludes, ThatMultiplyAreRefused) {
  for (int level = 0; level < 10; ++level) {
    std::string inside = link("l");
    for (int i = 0; i < 4 && level > 0; ++i)
      inside += include("m" + std::to_string(level - 1) + ".sdf", "<name>n" + std::to_string(i) + "</name>");
    write("m" + std::to_string(level) + ".sdf",
          "<sdf version='1.9'><model name='m'>" + inside + "</model></sdf>");
  }
  const Model model = read(include("m9.sdf"));
  EXPECT_TRUE(warns(model, "has, with what it includes, more than 200000 elements")) << warnings(model);
}

TEST_F(SdfIncludes, ThatCrashLibraryAreErrors) {
  write("p.sdf", "<sdf version='1.9'><model name='p'>" + link("l") + "</model></sdf>");
  const Model model = read(include("p.sdf", "<pose bogus='1'>0 0 0 0 0 0</pose>"));
  EXPECT_TRUE(warns(model, "its <pose> has the unknown attribute \"bogus\"")) << warnings(model);
  // libsdformat 12.3 dereferences a null pointer.
  const auto crash = try_read(world(include("p.sdf", "<plugin name='a' filename='b' bogus='1'/>")));
  EXPECT_TRUE(crash.ok() ||
              crash.error().message.find("world.sdf\" cannot be read by libsdformat: it crashed (") !=
                  std::string::npos)
      << crash.error().message;
  const auto old = try_read(world(include("p.sdf", "<pose frame=''>0 0 3 0 0 0</pose>"), "1.6"));
  ASSERT_TRUE(old.ok()) << old.error().message;
  expect_near(glm::dvec3(pose_of(*old, "p")[3]), {0, 0, 3});
}

TEST_F(SdfIncludes, MalformedAreSkipped) {
  write("urdf.sdf", "<robot name='r'/>");
  const Model model =
      read("<include/>\n<include><uri/></include>\n<!-- <include/> -->\n" + include("urdf.sdf") +
           "<include><uri>x</uri><name/></include><plugin name='p' filename='f'><include/></plugin>");
  EXPECT_TRUE(warns(model, "line 4: <include> is left out: it has no <uri>")) << warnings(model);
  EXPECT_TRUE(warns(model, "line 5: <include> is left out: it has no <uri>")) << warnings(model);
  EXPECT_TRUE(warns(model, "urdf.sdf\" is URDF")) << warnings(model);
  EXPECT_TRUE(warns(model, "its <name> is empty")) << warnings(model);
}

TEST_F(Sdf, OutsideImagesAreSkipped) {
  write("secret/a.png", "x");
  write("scene/own/a.png", "x");
  const auto read_scene = [&](const std::string& map) {
    return read_description(
        write("scene/world.sdf",
              world(shape("<box/>", "<material><diffuse>1 1 1</diffuse><pbr><metal><albedo_map>" + map +
                                        "</albedo_map></metal></pbr></material>"))),
        {});
  };
  const auto outside = read_scene("../secret/a.png");
  ASSERT_TRUE(outside.ok());
  EXPECT_TRUE(warns(*outside, "it lies outside the folders of the SDF file")) << warnings(*outside);
  EXPECT_TRUE(outside->images.empty());
  const auto inside = read_scene("own/a.png");
  ASSERT_TRUE(inside.ok());
  EXPECT_EQ(inside->images.size(), 1u);
}

TEST_F(Sdf, ErrorsNameFileAndRemedy) {
  EXPECT_NE(error_of("<sdf><world name='w'/></sdf>").find("write <sdf version=\"1.9\">"), std::string::npos);
  EXPECT_NE(error_of("<sdf version='seven'/>").find("unknown version \"seven\""), std::string::npos);
  EXPECT_NE(error_of("<sdf version='1.9'/>").find("no world and no model"), std::string::npos);
  const std::string loop =
      error_of("<!DOCTYPE x [<!ENTITY e SYSTEM '/etc/passwd'>]><sdf version='1.9'>&e;</sdf>");
  EXPECT_NE(loop.find("it defines entities"), std::string::npos) << loop;
  std::string deep;
  for (int i = 0; i < 200; ++i) deep += "<model name='m'>";
  EXPECT_NE(error_of("<sdf version='1.9'>" + deep).find("elements inside each other"), std::string::npos);
}

// Messages of libsdformat name the file and the line, although it reads a copy.
TEST_F(Sdf, MessagesOfTheLibraryAreWarnings) {
  const Model model = read(shape("<box/>") + "\n" + model_of("n", link("l") + "<bogus/>"));
  EXPECT_EQ(warnings(model).find((folder_.path() / "world.sdf").string() +
                                 ", line 9: <bogus> in <model> is unknown and ignored"),
            0u)
      << warnings(model);
  EXPECT_EQ(warnings(model).find("/proc/self"), std::string::npos) << warnings(model);
  const std::string error = error_of(
      world("\n" + model_of("n", link("l") + "<joint name='j' type='fixed'><parent>l</parent></joint>")));
  EXPECT_NE(
      error.find("world.sdf, line 6, /sdf/world[@name=\"w\"]/model[@name=\"n\"]/joint[@name=\"j\"]/child"),
      std::string::npos)
      << error;
  EXPECT_NE(error_of(world(model_of("m", link("l", "<pose>nan 0 0 0 0 0</pose>")))).find("world.sdf, line 4"),
            std::string::npos);
}

TEST_F(Sdf, HostileNumbersAreHarmless) {
  const Model model = read(
      model_of("m",
               link("far", "<pose>1e300 0 0 0 0 0</pose>") +
                   link("l", visual("<box><size>0 1 1</size></box>", "", "a") +
                                 visual("<box><size>1e300 1 1</size></box>", "", "b") +
                                 visual("<sphere><radius>-1</radius></sphere>", "", "c") +
                                 visual("<plane><normal>0 0 0</normal><size>1 1</size></plane>", "", "d") +
                                 visual("<box/>", "<transparency>1e300</transparency>", "e"))) +
      "<light name='i' type='point'><intensity>1e300</intensity></light>");
  for (const Node& each : model.nodes) {
    const glm::dmat4 pose = pose_of(model, each.name);
    EXPECT_TRUE(std::isfinite(glm::length(glm::dvec3(pose[3])))) << each.name;
  }
  EXPECT_TRUE(warns(model, "<pose> is not finite, or beyond 1e9 m")) << warnings(model);
  EXPECT_TRUE(warns(model, "visual \"m/l/b\" is left out: a size of its <geometry>")) << warnings(model);
  EXPECT_TRUE(warns(model, "visual \"m/l/a\" is left out: a size of its <geometry>")) << warnings(model);
  EXPECT_TRUE(node(model, "m/l/e"));
  std::string points;
  for (int i = 0; i < 20'000; ++i) points += "<point>" + std::to_string(i) + " 0</point>";
  const std::string line = "<polyline>" + points + "<height>1</height></polyline>";
  EXPECT_TRUE(warns(read(shape(line)), "is not a polygon of finite size"));
  EXPECT_TRUE(warns(read(shape(line + line + line + line + line + line)), "have more than 100000 points"));
}

// Every prefix of a file, and each of its characters replaced, ends in a model or an error.
TEST_F(Sdf, DamagedFilesDoNoHarm) {
  write("part/p.sdf", "<sdf version='1.9'><model name='part'>" + link("inner") + "</model></sdf>");
  const std::string whole = world(
      "<include><uri>part/p.sdf</uri><name>n</name><pose>1 0 0 0 0 0</pose></include>" +
      model_of("m", link("a") + link("b", visual("<box><size>1 1 1</size></box>")) +
                        "<joint name='j' type='revolute'><parent>a</parent><child>b</child><axis><xyz>0 0 1"
                        "</xyz></axis></joint>"));
  size_t read_count = 0;
  for (size_t i = 0; i < whole.size(); i += 37) {
    read_count += try_read(whole.substr(0, i)).ok();
    for (const char c : {'<', '"', '\0', '9'}) {
      std::string damaged = whole;
      damaged[i] = c;
      read_count += try_read(damaged).ok();
    }
  }
  EXPECT_GT(read_count, 0u);
}

TEST(SdfTrial, ReportsHowAProcessEnds) {
  EXPECT_TRUE(try_in_process([] {}).ok());
  const Result<void> crashed = try_in_process([] { std::abort(); });
  ASSERT_FALSE(crashed.ok());
  EXPECT_NE(crashed.error().message.find("it crashed (Aborted)"), std::string::npos)
      << crashed.error().message;
  const Result<void> full = try_in_process([] { throw std::bad_alloc(); });
  ASSERT_FALSE(full.ok());
  EXPECT_NE(full.error().message.find("memory"), std::string::npos);
}

}  // namespace
}  // namespace fire3dv::convert
