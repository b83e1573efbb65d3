#include "convert/mjcf/bodies/mjcf_bodies.h"

#include <algorithm>
#include <utility>

#include "renderer/scene/files.h"

namespace fire3dv::convert {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxObjects = 1'000'000;
constexpr int kMaxAttachments = 20;
constexpr size_t kMaxCopies = 10'000;
constexpr int kMaxReplicas = 1'000'000;

MjcfPose pose_of(const MjcfAttributes& from, const MjcfCompiler& compiler) {
  return {from.vec3("pos").value_or(glm::dvec3(0)), from.rotation(compiler)};
}

// Index of a replica with as many digits as the count has.
std::string padded(int index, int count) {
  const std::string all = std::to_string(count);
  std::string text = std::to_string(index);
  return std::string(all.size() - std::min(all.size(), text.size()), '0') + text;
}

struct Found {
  const MjcfElement* element = nullptr;
  size_t class_index = 0;
};

// Searches a body or frame by name, and the default class around it.
Found find_named(const MjcfSource& source, const MjcfElement& section, const std::string& kind,
                 const std::string& name, size_t around) {
  for (const MjcfElement& child : section.children) {
    const size_t class_index = source.class_of(child, around, "childclass");
    if (child.kind == kind && child.text("name") == name) return {&child, around};
    if (child.kind != "body" && child.kind != "frame" && child.kind != "replicate") continue;
    if (const Found found = find_named(source, child, kind, name, class_index); found.element) return found;
  }
  return {};
}

}  // namespace

Result<void> MjcfBodyReader::count_objects() {
  if (++objects_ <= kMaxObjects) return {};
  return Error{"the model has more than " + std::to_string(kMaxObjects) +
               " bodies, frames and geoms with all its replicas"};
}

void MjcfBodyReader::add_copy(const Scope& scope) {
  if (tree_.copies.size() < kMaxCopies) tree_.copies.push_back({scope.source, scope.prefix, scope.suffix});
}

Result<void> MjcfBodyReader::read(MjcfSource& source) {
  MjcfTreeBody world;
  world.name = "world";
  tree_.bodies.push_back(world);
  tree_.body_index.emplace("world", 0);
  const Scope scope{&source, 0, {}, MjcfDefaults::kMain, "", ""};
  add_copy(scope);
  for (const MjcfElement& section : source.root().children)
    if (section.kind == "worldbody")
      if (Result<void> done = read_children(section, scope); !done)
        return Error{quote(source.file().string()) + ": " + done.error().message};
  std::stable_sort(tree_.geoms.begin(), tree_.geoms.end(),
                   [](const MjcfTreeGeom& a, const MjcfTreeGeom& b) { return a.geom.body < b.geom.body; });
  const auto by_body = [](auto& objects, std::vector<MjcfTracked>& tracking) {
    std::vector<size_t> order(objects.size());
    for (size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::stable_sort(order.begin(), order.end(),
                     [&](size_t a, size_t b) { return objects[a].body < objects[b].body; });
    auto sorted = objects;
    std::vector<MjcfTracked> sorted_tracking;
    for (size_t i = 0; i < order.size(); ++i) {
      sorted[i] = objects[order[i]];
      sorted_tracking.push_back(tracking[order[i]]);
    }
    objects = std::move(sorted);
    tracking = std::move(sorted_tracking);
  };
  by_body(tree_.cameras, tree_.camera_tracking);
  by_body(tree_.lights, tree_.light_tracking);
  for (size_t i = 0; i < tree_.geoms.size(); ++i) tree_.geom_index.emplace(tree_.geoms[i].geom.name, i);
  // Coordinates are in the order of the bodies.
  for (MjcfTreeBody& body : tree_.bodies)
    for (MjcfJoint& joint : body.joints) {
      joint.first_coordinate = tree_.coordinates;
      tree_.coordinates += coordinates_of(joint.type);
    }
  return {};
}

Result<void> MjcfBodyReader::read_children(const MjcfElement& section, const Scope& scope) {
  for (const MjcfElement& child : section.children)
    if (Result<void> done = read_child(child, scope); !done) return done;
  return {};
}

Result<void> MjcfBodyReader::read_child(const MjcfElement& element, const Scope& scope) {
  if (Result<void> done = count_objects(); !done) return done;
  const std::string& kind = element.kind;
  if (kind == "body") return read_body(element, scope);
  if (kind == "frame") return read_frame(element, scope);
  if (kind == "replicate") return read_replicate(element, scope);
  if (kind == "attach") return read_attach(element, scope);
  if (kind == "composite") return read_composite(element, scope);
  if (kind == "flexcomp") return read_flexcomp(element, scope);
  if (kind == "geom")
    read_geom(element, scope);
  else if (kind == "joint" || kind == "freejoint")
    read_joint(element, scope);
  else if (kind == "inertial")
    read_inertial(element, scope);
  else if (kind == "site")
    read_site(element, scope);
  else if (kind == "camera")
    read_camera(element, scope);
  else if (kind == "light")
    read_light(element, scope);
  else if (kind != "plugin")
    scope.source->messages().warn(element.where() + ": the element is unknown and ignored");
  return {};
}

Result<void> MjcfBodyReader::read_body(const MjcfElement& element, const Scope& scope) {
  const MjcfAttributes from = scope.source->attributes(element, scope.class_index);
  MjcfTreeBody body;
  body.name = scope.name(from.name());
  body.parent = scope.body;
  body.pose = scope.frame * pose_of(from, scope.source->compiler());
  body.is_mocap = from.flag("mocap", false);
  Scope inner = scope;
  inner.body = tree_.bodies.size();
  inner.frame = {};
  inner.class_index = scope.source->class_of(element, scope.class_index, "childclass");
  if (!body.name.empty()) tree_.body_index.emplace(body.name, inner.body);
  tree_.bodies.push_back(std::move(body));
  return read_children(element, inner);
}

Result<void> MjcfBodyReader::read_frame(const MjcfElement& element, const Scope& scope) {
  Scope inner = scope;
  inner.frame =
      scope.frame * pose_of(scope.source->attributes(element, scope.class_index), scope.source->compiler());
  inner.class_index = scope.source->class_of(element, scope.class_index, "childclass");
  return read_children(element, inner);
}

Result<void> MjcfBodyReader::read_replicate(const MjcfElement& element, const Scope& scope) {
  const MjcfAttributes from = scope.source->attributes(element, scope.class_index);
  const int count = from.integer("count", 0);
  if (count < 0 || count > kMaxReplicas)
    return Error{element.where() + ": count is not from 0 to " + std::to_string(kMaxReplicas)};
  const glm::dvec3 offset = from.vec3("offset").value_or(glm::dvec3(0));
  const glm::dvec3 euler = from.vec3("euler").value_or(glm::dvec3(0));
  const std::string separator = from.text("sep");
  Scope inner = scope;
  inner.class_index = scope.source->class_of(element, scope.class_index, "childclass");
  MjcfPose pose;
  for (int i = 0; i < count; ++i) {
    pose.rotation = mjcf_euler_rotation(static_cast<double>(i) * euler, scope.source->compiler());
    inner.frame = scope.frame * pose;
    inner.suffix = separator + padded(i, count) + scope.suffix;
    add_copy(inner);
    if (Result<void> done = read_children(element, inner); !done) return done;
    if (Result<void> done = count_objects(); !done) return done;
    pose.position += pose.rotation * offset;
  }
  return {};
}

Result<MjcfSource*> MjcfBodyReader::attached_source(const MjcfElement& attach, const Scope& scope) {
  const std::string name = attach.text("model");
  if (name.empty()) return scope.source;  // a copy of the model's own body
  if (const MjcfElement* const asset = scope.source->model(name)) return open_asset(*asset, scope);
  // An asset without a name has that of the model in its file.
  for (const MjcfElement* asset : scope.source->unnamed_models()) {
    const Result<MjcfSource*> source = open_asset(*asset, scope);
    if (!source) return source;
    if ((*source)->root().text("model") == name) return source;
  }
  return Error{"there is no model " + quote(name) + " among the assets"};
}

Result<MjcfSource*> MjcfBodyReader::open_asset(const MjcfElement& asset, const Scope& scope) {
  auto& known = attached_[&asset];
  if (known) return known.get();
  const Result<fs::path> file =
      scope.source->files().find(asset.text("file"), scope.source->folders(asset, {}));
  if (!file) return file.error();
  Result<std::unique_ptr<MjcfSource>> source =
      MjcfSource::open(*file, scope.source->files(), scope.source->messages());
  if (!source) return source.error();
  known = std::move(*source);
  return known.get();
}

Result<void> MjcfBodyReader::read_attach(const MjcfElement& element, const Scope& scope) {
  const auto leave_out = [&](const std::string& reason) {
    scope.source->messages().warn(element.where() + " is left out: " + reason);
    return Result<void>();
  };
  if (scope.attachments == kMaxAttachments)
    return leave_out("attached models are nested more than " + std::to_string(kMaxAttachments) + " deep");
  const Result<MjcfSource*> source = attached_source(element, scope);
  if (!source) return leave_out(source.error().message);
  Scope inner = scope;
  inner.source = *source;
  inner.prefix = scope.prefix + element.text("prefix");
  inner.class_index = MjcfDefaults::kMain;
  ++inner.attachments;
  add_copy(inner);
  const std::string body = element.text("body"), frame = element.text("frame");
  for (const MjcfElement& section : (*source)->root().children) {
    if (section.kind != "worldbody") continue;
    if (body.empty() && frame.empty()) {
      if (*source == scope.source) return leave_out("it names neither a model nor a body");
      if (Result<void> done = read_children(section, inner); !done) return done;
      continue;
    }
    const Found found = find_named(**source, section, frame.empty() ? "body" : "frame",
                                   frame.empty() ? body : frame, MjcfDefaults::kMain);
    if (!found.element) continue;
    inner.class_index = found.class_index;
    return read_child(*found.element, inner);
  }
  if (body.empty() && frame.empty()) return {};
  return leave_out("the model has no " + std::string(frame.empty() ? "body " : "frame ") +
                   quote(frame.empty() ? body : frame));
}

}  // namespace fire3dv::convert
