// Typed attributes of MJCF elements, with default classes and compiler settings applied.
#pragma once

#include <cstddef>
#include <filesystem>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "convert/mjcf/xml/mjcf_element.h"
#include "convert/mjcf/xml/mjcf_files.h"

namespace fire3dv::convert {

// Settings of the compiler elements that concern what is drawn.
struct MjcfCompiler {
  enum class InertiaFromGeom { no, yes, unless_given };

  bool degrees = true;
  std::string euler_sequence = "xyz";  // capital letters: about fixed axes
  std::filesystem::path mesh_folder, texture_folder;
  bool strips_paths = false;
  bool fits_bounds = false;  // fitaabb: primitives enclose the mesh's bounds instead of matching its inertia
  bool discards_visual = false;
  bool limits_automatically = true;  // autolimits: a joint with a range is limited
  InertiaFromGeom inertia_from_geom = InertiaFromGeom::unless_given;
  int first_inertia_group = 0, last_inertia_group = 5;

  double radians(double angle) const;
};

// Classes of default elements. A class refers to its parent, so that values are inherited without copies.
class MjcfDefaults {
 public:
  MjcfDefaults() : classes_(1) {}

  // Reads a top-level default element into the main class, and its nested classes.
  void read(const MjcfElement& section, MjcfMessages& messages);

  static constexpr size_t kMain = 0;
  // Empty: unknown class.
  std::optional<size_t> find(std::string_view name) const;
  // Elements that set values for `kind` in the class and its ancestors, nearest first.
  std::vector<const MjcfElement*> chain(size_t index, std::string_view kind) const;

 private:
  struct Class {
    size_t parent = 0;                                         // own index: none
    std::map<std::string, MjcfElement, std::less<>> elements;  // by kind
  };
  void read_class(const MjcfElement& section, size_t index, MjcfMessages& messages);

  std::vector<Class> classes_;
  std::map<std::string, size_t, std::less<>> by_name_{{"main", kMain}};
};

// View of an element and its defaults; both must outlive it. Malformed values are reported and then count as
// absent.
class MjcfAttributes {
 public:
  MjcfAttributes(const MjcfElement& element, const MjcfDefaults& defaults, size_t class_index,
                 MjcfMessages& messages, std::string_view default_kind = {});

  const MjcfElement& element() const { return element_; }
  std::string name() const { return element_.text("name"); }

  const std::string* find(std::string_view name) const;
  std::string text(std::string_view name) const;
  std::optional<double> number(std::string_view name) const;
  double number(std::string_view name, double otherwise) const { return number(name).value_or(otherwise); }
  int integer(std::string_view name, int otherwise) const;
  bool flag(std::string_view name, bool otherwise) const;
  std::optional<glm::dvec2> vec2(std::string_view name) const;
  std::optional<glm::dvec3> vec3(std::string_view name) const;
  std::optional<glm::dvec4> vec4(std::string_view name) const;
  // Exactly `count` numbers.
  std::optional<std::vector<double>> numbers(std::string_view name, size_t count) const;
  // Up to three numbers; an element that sets fewer takes the rest from its classes.
  glm::dvec3 size(const glm::dvec3& otherwise) const;

  // Rotation from quat, axisangle, xyaxes, zaxis or euler.
  glm::dquat rotation(const MjcfCompiler& compiler) const;

  void warn(const std::string& message) const { messages_.warn(element_.where() + ": " + message); }

 private:
  std::optional<std::vector<double>> parse(std::string_view name, const std::string& text,
                                           size_t count) const;
  std::optional<glm::dquat> alternative(const MjcfElement& from, const MjcfCompiler& compiler) const;

  const MjcfElement& element_;
  std::vector<const MjcfElement*> layers_;  // the element, then its defaults, nearest first
  MjcfMessages& messages_;
};

// Shortest rotation from +Z to the direction. Empty: it has no length.
std::optional<glm::dquat> mjcf_z_rotation(const glm::dvec3& z);

// Rotation by Euler angles in the compiler's unit and sequence.
glm::dquat mjcf_euler_rotation(const glm::dvec3& angles, const MjcfCompiler& compiler);

// Numbers separated by blanks, up to the first word that is none. Decimal point, whatever the locale.
std::vector<double> mjcf_numbers(std::string_view text, size_t most);
// Whether all of the text is numbers.
bool is_mjcf_numbers(std::string_view text, size_t most);

}  // namespace fire3dv::convert
