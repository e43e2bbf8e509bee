#Tijera Pieza B
G20 # Unidades en pulgadas
G90 # Modo de coordenadas absolutas
G00 Z 0.125 # Subir herramienta sin corte
G00 X0.5 Y 1.75 # Mover a la sección interna
G01 Z-0.25
G02 X0.5 Y 2.25 I0 J0.25
G01 X2 Y2.25
G02 X2 Y1.75 I0 J-0.25
G01 X0.5 Y1.75 # Final de corte interno
G01 Z0.25
G00 X0.5 Y1.5 # Cortar mango de la tijera
G01 Z-0.25
G02 X0.5 Y2.5 I0 J0.5
G01 X2 Y2.5
G02 X2.5 Y2 I0 J-.5
G01 X3 Y1
G01 X6.5 Y.25 # Inicia punta de la tijera
G01 X6.5 Y0
G01 X4 Y0 # Fin de punta
G01 Z0.25
G00 X4.5 Y0.25 # Orificio tornillo
G01 Z-0.25
G02 X4.5 Y0.5 I0 J0.125
G02 X4.5 Y0.25 I0 J-0.125
G01 Z0.25
G00 X4 Y0 # Continuar corte de mango
G03 X3.5 Y0.5 I-.5 J0
G01 X3 Y0.5
G01 X2Y1.5
G01 X0.5Y1.5 # Fin de toda la pieza
G01 Z0.25
G00 X0Y0 # Volver a coordenada HOME
G00 Z0
