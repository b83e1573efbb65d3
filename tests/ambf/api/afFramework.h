// Stub of the AMBF API: the subset of classes and members that adapters/ambf/plugin.cpp uses. The plugin
// compiles and runs against it where AMBF is not installed. Names, signatures and meanings follow AMBF; the
// bodies are test doubles whose objects stand at poses that the test sets.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace chai3d {

class cTransform {
 public:
  double m[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};  // m[column][row]
};

struct cColorf {
  float rgba[4] = {0.5f, 0.25f, 1, 1};
  float getR() const { return rgba[0]; }
  float getG() const { return rgba[1]; }
  float getB() const { return rgba[2]; }
  float getA() const { return rgba[3]; }
};

struct cMaterial {
  cColorf m_diffuse;
};

struct cMesh {
  cMaterial* m_material = nullptr;
};

class cMultiMesh {
 public:
  bool getShowEnabled() const { return shown; }
  unsigned int getNumMeshes() const { return static_cast<unsigned int>(meshes.size()); }
  cMesh* getMesh(unsigned int index) { return meshes[index]; }
  bool shown = true;
  std::vector<cMesh*> meshes;
};

enum cStereoMode { C_STEREO_DISABLED, C_STEREO_PASSIVE_LEFT_RIGHT };

class cCamera {
 public:
  double getNearClippingPlane() { return near_m; }
  double getFarClippingPlane() { return far_m; }
  double near_m = 0.1, far_m = 10;
};

}  // namespace chai3d

template <typename T>
struct btAlignedObjectArray {
  int size() const { return static_cast<int>(items.size()); }
  T& operator[](int index) { return items[static_cast<size_t>(index)]; }
  const T& operator[](int index) const { return items[static_cast<size_t>(index)]; }
  std::vector<T> items;
};

struct btVector3 {
  double values[4]{};
  double operator[](int index) const { return values[index]; }
};

struct btSoftBody {
  struct Node {
    btVector3 m_x;
  };
  struct Face {
    Node* m_n[3];
  };
  btAlignedObjectArray<Node> m_nodes;
  btAlignedObjectArray<Face> m_faces;
};

namespace ambf {

class afWorld;
using afWorldPtr = afWorld*;

class afBaseObject {
 public:
  virtual ~afBaseObject() = default;
  chai3d::cTransform getLocalTransform() { return local; }
  afBaseObject* getParentObject() { return parent; }
  std::string getQualifiedName() { return name; }
  chai3d::cTransform local;
  afBaseObject* parent = nullptr;
  std::string name;
};
using afBaseObjectMap = std::map<std::string, afBaseObject*>;

// As in AMBF, afMeshObject is not the first base class, so a cast from afBaseObject* must know the class.
class afMeshObject {
 public:
  virtual ~afMeshObject() = default;
  chai3d::cMultiMesh* m_visualMesh = nullptr;
};

class afInertialObject : public afBaseObject, public afMeshObject {
 public:
  btSoftBody* m_bulletSoftBody = nullptr;
};
class afRigidBody : public afInertialObject {};
class afGhostObject : public afInertialObject {};
class afSoftBody : public afInertialObject {};
class afLight : public afBaseObject {};

class afCamera : public afBaseObject {
 public:
  double getFieldViewAngle() const { return vertical_fov_rad; }
  chai3d::cCamera* getInternalCamera() { return &inner; }
  bool isOrthographic() { return orthographic; }
  chai3d::cCamera inner;
  chai3d::cStereoMode m_stereoMode = chai3d::C_STEREO_DISABLED;
  double vertical_fov_rad = 0.7;
  bool orthographic = false;
};

class afWorld {
 public:
  afBaseObjectMap* getRigidBodyMap() { return &bodies; }
  afBaseObjectMap* getGhostObjectMap() { return &ghosts; }
  afBaseObjectMap* getLightMap() { return &lights; }
  afBaseObjectMap* getCameraMap() { return &cameras; }
  afBaseObjectMap* getSoftBodyMap() { return &soft_bodies; }
  bool isHeadless() { return headless; }
  bool isPhysicsPaused() { return paused; }
  double getSimulationTime() { return time_s; }
  afBaseObjectMap bodies, ghosts, lights, cameras, soft_bodies;
  bool headless = true, paused = false;
  double time_s = 0;
};

class afSystemPaths {
 public:
  static std::string& getRootPath() {
    static std::string path = "/nowhere";
    return path;
  }
};

enum afInitStatus { SUCCESS = 1, ERROR = -1 };

class afSimulatorPlugin {
 public:
  virtual ~afSimulatorPlugin() = default;
  virtual int init(int, char**, const afWorldPtr) { return -1; }
  virtual void graphicsUpdate() {}
  virtual void physicsUpdate(double) {}
  virtual void reset() {}
  virtual bool close() { return false; }

 protected:
  afWorldPtr m_worldPtr = nullptr;
};

}  // namespace ambf
