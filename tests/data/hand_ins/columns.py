#!/usr/bin/env python3
# -*- coding: utf-8 -*-
from math import *
import numpy as np
import matplotlib.pyplot as plt
import rclpy
from lab_amoro.parallel_robot import *

# Paramètres géométriques du mécanisme
l = 0.09
d = 0.118
# Paramètres dynamiques
ZZ1R = 1.0 * 0.045 * 0.045
ZZ2R = 1.0 * 0.045 * 0.045
mR = 0.5

R90 = np.array([[0, -1], [1, 0]])

def dgm(q11, q21, assembly_mode):
	# vecteur A22H (éq. 1)
	A22H = 0.5*np.array([[-l*cos(q21)-d+l*cos(q11)],
		[-l*sin(q21)+l*sin(q11)]])
	a = np.linalg.norm(A22H)
	h = sqrt(l**2 - a**2)
	HA13 = assembly_mode * (h / a) * np.dot(R90, A22H)
	OA22 = np.array([[d / 2 + l * cos(q21)], [l * sin(q21)]])
	OA13 = OA22 + A22H + HA13
	x = OA13[0]
	y = OA13[1]
	return x, y

def igm(x, y, gamma1, gamma2):
	# bras gauche
	A11M1 = 0.5 * np.array([[x + d / 2], [y]])
	c1 = np.linalg.norm(A11M1)
	b1 = sqrt(l**2 - c1**2)
	A11A12 = A11M1 + gamma1 * (b1 / c1) * np.dot(R90, A11M1)
	q11 = atan2(A11A12[1], A11A12[0])
	# bras droit
	A21M2 = 0.5 * np.array([[x - d / 2], [y]])
	c2 = np.linalg.norm(A21M2)
	b2 = sqrt(l**2 - c2**2)
	A21A22 = A21M2 + gamma2 * (b2 / c2) * np.dot(R90, A21M2)
	q21 = atan2(A21A22[1], A21A22[0])
	return q11, q21

def dgm_passive(q11, q21, assembly_mode):
	x, y = dgm(q11, q21, assembly_mode)
	q12 = atan2(y / l - sin(q11), x / l + d / (2 * l) - cos(q11)) - q11
	q22 = atan2(y / l - sin(q21), x / l - d / (2 * l) - cos(q21)) - q21
	return q12, q22

def get_u(q):
	return np.array([[cos(q)], [sin(q)]])

def get_v(q):
	return np.array([[-sin(q)], [cos(q)]])

def compute_A_B(q11, q12, q21, q22):
	u12 = get_u(q11 + q12)
	u22 = get_u(q21 + q22)
	A = np.array([u12.T[0], u22.T[0]])
	B = np.array([[l * np.dot(u12.T, get_v(q11))[0][0], 0], [0, l * np.dot(u22.T, get_v(q21))[0][0]]])
	return A, B

def compute_d(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
	u11, u21 = get_u(q11), get_u(q21)
	u12, u22 = get_u(q11 + q12), get_u(q21 + q22)
	d1 = -l * q11D**2 * np.dot(u12.T, u11) - l * (q11D + q12D) ** 2
	d2 = -l * q21D**2 * np.dot(u22.T, u21) - l * (q21D + q22D) ** 2
	return np.array([d1[0], d2[0]])

def dkm(q11, q12, q21, q22, q11D, q21D):
	A, B = compute_A_B(q11, q12, q21, q22)
	qD = np.array([[q11D], [q21D]])
	xiD = np.dot(np.linalg.inv(A), np.dot(B, qD))
	return xiD[0], xiD[1]

def ikm(q11, q12, q21, q22, xD, yD):
	A, B = compute_A_B(q11, q12, q21, q22)
	xiD = np.array([[xD], [yD]])
	qD = np.dot(np.linalg.inv(B), np.dot(A, xiD))
	return qD[0], qD[1]

def dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD):
	v12, v22 = get_v(q11 + q12), get_v(q21 + q22)
	xiD = np.array([[xD], [yD]])
	C = np.array([[l * np.dot(v12.T, get_v(q11))[0, 0] + l, 0], [0, l * np.dot(v22.T, get_v(q21))[0, 0] + l]])
	V = np.array([v12.T[0], v22.T[0]])
	qpD = (1 / l) * (np.dot(V, xiD) - np.dot(C, np.array([[q11D], [q21D]])))
	return qpD[0], qpD[1]

def dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
	A, B = compute_A_B(q11, q12, q21, q22)
	D = compute_d(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
	qDD = np.array([[q11DD], [q21DD]])
	xiDD = np.dot(np.linalg.inv(A), np.dot(B, qDD) + D)
	return xiDD[0], xiDD[1]

def ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD):
	A, B = compute_A_B(q11, q12, q21, q22)
	D = compute_d(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
	xiDD = np.array([[xDD], [yDD]])
	qDD = np.dot(np.linalg.inv(B), np.dot(A, xiDD) - D)
	return qDD[0], qDD[1]

def dkm2_passive(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD, xDD, yDD):
	v12, v22 = get_v(q11 + q12), get_v(q21 + q22)
	xiDD = np.array([[xDD], [yDD]])
	e1 = -l * q11D**2 * np.dot(v12.T, get_u(q11))
	e2 = -l * q21D**2 * np.dot(v22.T, get_u(q21))
	q12DD = (np.dot(v12.T, xiDD) - q11DD * (l * np.dot(v12.T, get_v(q11)) + l) - e1) / l
	q22DD = (np.dot(v22.T, xiDD) - q21DD * (l * np.dot(v22.T, get_v(q21)) + l) - e2) / l
	return q12DD[0], q22DD[0]

def dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
	A, B = compute_A_B(q11, q12, q21, q22)
	D = compute_d(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
	J = np.dot(np.linalg.inv(A), B)
	Z = np.array([[ZZ1R, 0], [0, ZZ2R]])
	M = Z + mR * np.dot(J.T, J)
	c = mR * np.dot(J.T, np.dot(np.linalg.inv(A), D))
	return M, c
