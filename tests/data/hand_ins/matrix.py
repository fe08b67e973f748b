"""
Created for the AMORO lab, five-bar robot
"""

import numpy as np
from numpy import sin, cos, pi, sqrt, arctan2

l=0.09
d=0.118
ZZ1R=0.002
ZZ2R=0.002
mR=0.5
E=np.matrix([[0.,-1.],[1.,0.]])

def u(a): return np.matrix([[cos(a)],[sin(a)]])

def v(a): return E*u(a)

def dgm(q11,q21,assembly_mode):
  A12=np.matrix([[-d/2],[0]])+l*u(q11)
  A22=np.matrix([[d/2],[0]])+l*u(q21)
  H=(A12+A22)/2
  w=(A12-A22)/2
  a=np.linalg.norm(w)
  P=H+assembly_mode*sqrt(l**2-a**2)/a*E*w
  print("dgm",P)
  return P[0,0],P[1,0]

def igm(x,y,gamma1,gamma2):
  out=[]
  for base,g in [(-d/2,gamma1),(d/2,gamma2)]:
    s=np.matrix([[x-base],[y]])/2
    c=np.linalg.norm(s)
    b=sqrt(l**2-c**2)
    e=s+g*b/c*E*s
    out.append(arctan2(e[1,0],e[0,0]))
  return out[0],out[1]

def dgm_passive(q11,q21,assembly_mode):
  x,y=dgm(q11,q21,assembly_mode)
  w1=np.array([x+d/2-l*cos(q11),y-l*sin(q11)])
  w2=np.array([x-d/2-l*cos(q21),y-l*sin(q21)])
  q12=arctan2(w1[1],w1[0])-q11
  q22=arctan2(w2[1],w2[0])-q21
  return q12,q22

def AB(q11,q12,q21,q22):
  A=np.vstack([u(q11+q12).T,u(q21+q22).T])
  B=np.matrix([[l*(u(q11+q12).T*v(q11))[0,0],0],[0,l*(u(q21+q22).T*v(q21))[0,0]]])
  return A,B

def bias(q11,q12,q21,q22,q11D,q12D,q21D,q22D):
  b1=-l*q11D**2*(u(q11+q12).T*u(q11))[0,0]-l*(q11D+q12D)**2
  b2=-l*q21D**2*(u(q21+q22).T*u(q21))[0,0]-l*(q21D+q22D)**2
  return np.matrix([[b1],[b2]])

def dkm(q11,q12,q21,q22,q11D,q21D):
  A,B=AB(q11,q12,q21,q22)
  return A.I*B*np.matrix([[q11D],[q21D]])

def ikm(q11,q12,q21,q22,xD,yD):
  A,B=AB(q11,q12,q21,q22)
  return B.I*A*np.matrix([[xD],[yD]])

def dkm_passive(q11,q12,q21,q22,q11D,q21D,xD,yD):
  xi=np.matrix([[xD],[yD]])
  w1=(v(q11+q12).T*(xi-l*q11D*v(q11)))[0,0]/l
  w2=(v(q21+q22).T*(xi-l*q21D*v(q21)))[0,0]/l
  return w1-q11D,w2-q21D

def dkm2(q11,q12,q21,q22,q11D,q12D,q21D,q22D,q11DD,q21DD):
  A,B=AB(q11,q12,q21,q22)
  D=bias(q11,q12,q21,q22,q11D,q12D,q21D,q22D)
  return A.I*(B*np.matrix([[q11DD],[q21DD]])+D)

def ikm2(q11,q12,q21,q22,q11D,q12D,q21D,q22D,xDD,yDD):
  A,B=AB(q11,q12,q21,q22)
  D=bias(q11,q12,q21,q22,q11D,q12D,q21D,q22D)
  return B.I*(A*np.matrix([[xDD],[yDD]])-D)

def dkm2_passive(q11,q12,q21,q22,q11D,q12D,q21D,q22D,q11DD,q21DD,xDD,yDD):
  xi=np.matrix([[xDD],[yDD]])
  e1=xi-l*q11DD*v(q11)+l*q11D**2*u(q11)
  e2=xi-l*q21DD*v(q21)+l*q21D**2*u(q21)
  return (v(q11+q12).T*e1)[0,0]/l-q11DD,(v(q21+q22).T*e2)[0,0]/l-q21DD

def dynamic_model(q11,q12,q21,q22,q11D,q12D,q21D,q22D):
  A,B=AB(q11,q12,q21,q22)
  D=bias(q11,q12,q21,q22,q11D,q12D,q21D,q22D)
  J=A.I*B
  M=np.matrix([[ZZ1R,0],[0,ZZ2R]])+mR*J.T*J
  c=mR*J.T*A.I*D
  return M,c
